"""Fonts that were made are kept, and made again when what they are made of changes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from chapters._ext import robust_slam_fonts as fonts


def test_a_font_is_made_again_when_its_file_or_its_module_changes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fonts, "KEPT", tmp_path / "kept")
    whole, module = tmp_path / "whole.ttf", tmp_path / "module.py"
    whole.write_bytes(b"font")
    module.write_bytes(b"signs")

    def held(make: Callable[[], bytes]) -> bytes:
        return fonts.kept(make, whole, str(module))

    assert held(lambda: b"first") == held(lambda: b"never made") == b"first"
    module.write_bytes(b"more signs")
    assert held(lambda: b"second") == b"second"
    whole.write_bytes(b"another font")
    assert held(lambda: b"third") == held(lambda: b"never made") == b"third"
    assert len(list((tmp_path / "kept").iterdir())) == 1
    monkeypatch.setattr(fonts, "MAKERS", ("pytest",))
    assert held(lambda: b"fourth") == b"fourth"
