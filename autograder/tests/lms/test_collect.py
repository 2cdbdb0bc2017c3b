"""``autograder collect``: each notebook of a zip is in its student's folder, or is told."""

import json
import stat
import struct
import zipfile
from pathlib import Path

import pytest
from robust_slam_autograder.lms import downloads

from .. import toy
from ..conftest import Run

CANVAS = """\
Student,ID,SIS User ID,SIS Login ID,Section
    Points Possible,,,,
"Smith, John",12345,s1,jsmith,A
"Lovelace, Ada",67,s2,ada@example.edu,A
"Twin, Al",8,s3,al,B
"""
MOODLE = """\
First name,Last name,Email address
Jane,Smith,jane@example.edu
Zoë,"O'Neill  Jr",zoe
Al,Twin,al1
Al,Twin,al2
"""
ONE = json.dumps(toy.answer())
OTHER = json.dumps(toy.answer("def double(x):\n    return x\n"))
FILE = f"{toy.NAME}.ipynb"


@pytest.fixture
def collect(tmp_path: Path, autograder: Run, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Collect files, with a system's roster: exit status, output, errors."""
    monkeypatch.chdir(tmp_path)
    toy.make_tree(tmp_path)

    def command(system: str, files: dict[str, str], *arguments: object, spoil=bytes, **roster):
        made = tmp_path / "all.zip"
        with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as file:
            for name, text in files.items():
                file.writestr(zipfile.ZipInfo(name, (2026, 10, 20, 12, 30, 2)), text)
        made.write_bytes(spoil(made.read_bytes()))
        usual = CANVAS if system == "canvas" else MOODLE
        (tmp_path / "roster.csv").write_text(roster.get("roster", usual), encoding="utf-8")
        where = ("--format", system, "--roster", "roster.csv", "--submitted", "in")
        return autograder("collect", made, *where, *arguments)

    return command


def written(folder: Path) -> dict[str, str]:
    there = sorted((folder / "in").rglob("*")) if (folder / "in").exists() else []
    there = [path for path in there if path.is_file() and path.name != downloads.LEFT_OUT]
    return {str(p.relative_to(folder / "in")): p.read_text() for p in there}


def test_what_canvas_hands_out_becomes_a_classs_folders(tmp_path, collect):
    files = {
        f"smithjohn_12345_678_{FILE}": ONE,
        f"lovelaceada_LATE_67_679_{toy.NAME}-1.ipynb": OTHER,
    }
    status, out, err = collect("canvas", files)
    assert (status, err) == (0, "")
    assert written(tmp_path) == {
        f"jsmith/{toy.NAME}/{FILE}": ONE,
        f"ada@example.edu/{toy.NAME}/{FILE}": OTHER,
    }
    assert f"late, says the system: 1 of {toy.NAME} (ada@example.edu)" in out
    assert f"no notebook of {toy.NAME}: 1 (al)" in out and "2 notebooks of 2 students" in out
    (path,) = (tmp_path / "in" / "jsmith").rglob("*.ipynb")
    assert path.stat().st_mtime % 60 == 2, "the zip's time, for the late policy"
    assert collect("canvas", files)[0] == 0, "the same again changes nothing"


def test_what_moodle_hands_out_becomes_a_classs_folders(tmp_path, collect):
    files = {
        f"Jane Smith_901_assignsubmission_file_/{FILE}": ONE,
        f"Zoe\u0308 O'Neill Jr_902_assignsubmission_file_{toy.NAME} (1).ipynb": OTHER,
        f"Al Twin_903_assignsubmission_file_/{FILE}": ONE,
    }
    status, _, err = collect("moodle", files)
    several = "may be of several people on the roster, lines 4 (al1) and 5 (al2)"
    assert status == 1 and several in err
    assert written(tmp_path) == {
        f"jane@example.edu/{toy.NAME}/{FILE}": ONE,
        f"zoe/{toy.NAME}/{FILE}": OTHER,
    }
    head, *lines = MOODLE.splitlines()
    numbered = [f"Participant {n},{line}" for n, line in enumerate(lines, start=901)]
    roster = "\n".join([f"Identifier,{head}", *numbered])
    assert collect("moodle", files, roster=roster)[0] == 0
    assert f"al1/{toy.NAME}/{FILE}" in written(tmp_path)


JANE = "Jane Smith_901_assignsubmission_file"


@pytest.mark.parametrize(
    "name",
    [
        *(f"{JANE}/{FILE}", f"{JANE}_/{FILE}", f"{JANE}_{FILE}", f"{JANE}_/a/b/{FILE}"),
        *(f"all/all/{JANE}/a/{FILE}", f"all\\{JANE}\\{FILE}", f"all/{JANE}_{FILE}"),
        *(f"Smith, Jane{JANE[10:]}/{FILE}", f"Smith, Jane{JANE[10:]}_{FILE}"),
        f"{JANE}/Al Twin{JANE[10:]}/{FILE}",
    ],
)
def test_every_way_that_moodle_and_those_who_pack_it_anew_name_a_file(tmp_path, collect, name):
    beside = (f"__MACOSX/all/._{FILE}", f"._{FILE}", ".DS_Store", "all/desktop.ini", "all/")
    roster = f"sep=;\n{MOODLE.replace(',', ';')}"
    status, _, err = collect("moodle", dict.fromkeys([name, *beside], ONE), roster=roster)
    assert (status, err) == (0, "")
    assert set(written(tmp_path)) == {f"jane@example.edu/{toy.NAME}/{FILE}"}


def test_a_roster_in_another_language_is_read_by_the_columns_that_are_named(tmp_path, collect):
    dutch = MOODLE.replace("First name,Last name", "Voornaam,Achternaam")
    files = {f"{JANE}/{FILE}": ONE}
    status, out, err = collect("moodle", files, roster=dutch)
    assert (status, out) == (2, "") and "There are Voornaam, Achternaam, Email" in err
    assert "wanted are First name and Last name" in err and written(tmp_path) == {}
    assert collect("moodle", files, "--name", " Voornaam", "Achternaam", roster=dutch)[0] == 0
    assert collect("moodle", files, "--name", "Naam", roster=dutch)[0] == 2
    german = MOODLE.replace("First name,Last name", "Vorname,Nachname")
    assert collect("moodle", files, roster=german)[0] == 0
    assert "--name is for Moodle" in collect("canvas", files, "--name", "Student")[2]


DAMAGE = {
    "stream": (0, 30 + len(f"smithjohn_12345_678_{FILE}"), b"\xff" * 9),
    "local header": (0, 0, b"KP"),
    "CRC": (1, 16, b"1234"),
    "method": (1, 10, b"\x63"),
    "bzip2": (1, 10, b"\x0c"),
    "lzma": (1, 10, b"\x0e"),
    "password": (1, 8, b"\1"),
    "place": (1, 42, b"\xff\xff\xff\x7f"),
}
"""Whether it is in the index, where it begins there, and the bytes that stand there."""


@pytest.mark.parametrize(("index", "place", "new"), DAMAGE.values(), ids=DAMAGE)
def test_a_damaged_file_costs_its_own_student_alone(tmp_path, collect, index, place, new):
    bad, good = f"smithjohn_12345_678_{FILE}", f"twinal_8_3_{FILE}"

    def damage(data: bytes) -> bytes:
        at = place + (data.index(b"PK\1\2") if index else 0)
        return data[:at] + new + data[at + len(new) :]

    status, _, err = collect("canvas", {bad: ONE, good: ONE}, spoil=damage)
    assert status == 1 and err.startswith(f"left out: {bad} cannot be read from the zip (")
    assert set(written(tmp_path)) == {f"al/{toy.NAME}/{FILE}"}


def test_odd_names_are_taken_and_of_two_files_of_one_name_neither(tmp_path, collect):
    odd = [f"smithjohn_12345_678_a:b\\{FILE}", f"all\\lovelaceada_67_1__{FILE}"]
    twice = [f"twinal_8_3_{FILE}", f"twinal_8_3_{FILE}".upper()]
    first, second = (name.encode() for name in twice)
    files = dict.fromkeys([*odd, *twice], ONE)
    spoil = {"spoil": lambda data: data.replace(second, first)}
    status, _, err = collect("canvas", files, "--assignment", toy.NAME, **spoil)
    assert status == 1 and "stands in the zip twice" in err and len(err.splitlines()) == 1
    assert {path.split("/")[0] for path in written(tmp_path)} == {"jsmith", "ada@example.edu"}


@pytest.mark.parametrize("stamp", [bytes(4), b"\0\0\x21\0", b"\xff" * 4])
def test_a_file_without_a_time_has_the_zips(tmp_path, collect, stamp):
    time = struct.pack("<HH", 12 << 11 | 30 << 5 | 1, 46 << 9 | 10 << 5 | 20)
    files = {f"smithjohn_12345_678_{FILE}": ONE}
    status, out, _ = collect("canvas", files, spoil=lambda data: data.replace(time, stamp))
    assert status == 0 and f"no time in the zip, so its own counts: 1 of {toy.NAME} (jsm" in out
    (path,) = (tmp_path / "in").rglob("*.ipynb")
    now = (tmp_path / "all.zip").stat().st_mtime
    assert path.stat().st_mtime == pytest.approx(now, abs=1)


def test_names_that_macos_writes_as_utf8_without_saying_so_are_read(tmp_path, collect):
    plain, mac = f"Zo== ONeill Jr{JANE[10:]}/{FILE}".encode(), "Zoë".encode()
    collect("moodle", {plain.decode(): ONE}, spoil=lambda data: data.replace(b"Zo==", mac))
    assert set(written(tmp_path)) == {f"zoe/{toy.NAME}/{FILE}"}


class OfALaterPython(zipfile.ZipFile):
    """Python changes its mind about what a name is that is not the UTF-8 that it says."""

    def __init__(self, *arguments):
        try:
            super().__init__(*arguments)
        except UnicodeDecodeError as error:
            raise zipfile.BadZipFile("a name is not UTF-8") from error


@pytest.mark.parametrize("kind", [zipfile.ZipFile, OfALaterPython])
def test_names_that_say_that_they_are_utf8_and_are_not_cost_nobody_a_notebook(
    tmp_path, collect, monkeypatch, kind
):
    odd = dict.fromkeys([f"smithé_12345_1_{FILE}", f"Zoë_67_1_{FILE}"], ONE)
    monkeypatch.setattr(downloads.zipfile, "ZipFile", kind)
    done = collect("canvas", odd, spoil=lambda data: data.replace("é".encode(), b"!\xff"))
    assert (done[0], done[2]) == (0, "")
    assert len(written(tmp_path)) == 2


TWINS = "First name,Last name,Email address\nAna,O'Dell,ana\nAna,ODell,other\nBo,_Ü,bo\n"
NAMED = ["--assignment", toy.NAME]
JOHN = "smithjohn_12345_678_"
DOUBTFUL = {
    f"smithjohn_99_678_{FILE}": "is of no one on the roster",
    f"{JOHN}notes.pdf": "is no notebook",
    FILE: "has not the name that this system gives",
    f"{JOHN}homework.ipynb": "does not say its assignment: add --assignment",
    f"twin_8_12345_67_{FILE}": "may be of several people on the roster",
    f"a/b/smithjohn_99_1_\x1b[31m{FILE}": "left out: a/b/smithjohn_99_1_\\x1b[31m",
}
NUMBERED = """Identifier,Full name,Email address
Participant 17,Jane Smith,jane
Participant 18,Bo Ray,bo
"""
WRONG = "has not the name that this system gives"
SWAPPED = "has another name, or number beside it, than the roster's line"


def moodle(name: str, number: int = 9) -> str:
    return f"{name}_{number}_assignsubmission_file/{FILE}"


ANA, BO = moodle("Ana ODell"), moodle("Bo Ü")
BO_RAYS = moodle("Bo Ray").removesuffix(f"/{FILE}")
TURNED = ["--name", "Last name", "First name"]
TWO = [f"smithjohn_12345_{n}_{FILE}" for n in (1, 2)]


@pytest.mark.parametrize(
    ("roster", "files", "arguments", "told", "times", "taken"),
    [
        (MOODLE, [moodle("Smith Jane")], [], f"{SWAPPED} 2 (jane@example.edu)", 1, set()),
        (MOODLE, [moodle("Lou-Jane Smith")], [], f"{SWAPPED} 2 (jane@", 1, set()),
        (MOODLE, [moodle("Smith Jane")], TURNED, "", 1, {"jane@example.edu"}),
        (NUMBERED, [f"{BO_RAYS}_x/{moodle('Jane Smith', 17)}"], [], WRONG, 1, set()),
        (NUMBERED, [moodle("Bo Ray", 17)], [], f"{SWAPPED} 2 (jane)", 1, set()),
        (NUMBERED, [moodle("Team Red", 17)], [], f"{SWAPPED} 2 (jane)", 1, set()),
        (NUMBERED, [moodle("Bo Ray", 19)], [], f"{SWAPPED} 3 (bo)", 1, set()),
        (NUMBERED, [moodle("Participant", 17)], [], "", 1, {"jane"}),
        (NUMBERED, [moodle("Participant 17", 17)], [], "", 1, {"jane"}),
        (NUMBERED, [moodle("Team-2-Bo Ray", 18)], [], "", 1, {"bo"}),
        *((CANVAS, [name], [], why, 1, set()) for name, why in DOUBTFUL.items()),
        # As Moodle cleans the names on the roster, two are equal.
        (TWINS, [ANA, BO], [], "lines 2 (ana) and 3 (other)", 1, {"bo"}),
        (CANVAS, [*TWO, f"twinal_8_3_{FILE}"], [], "several notebooks of jsmith", 2, {"al"}),
        (CANVAS, [f"{JOHN}homework.ipynb"], NAMED, "", 1, {"jsmith"}),
    ],
)
def test_what_is_in_doubt_is_told_and_never_guessed(
    tmp_path, collect, roster, files, arguments, told, times, taken
):
    system = "canvas" if roster is CANVAS else "moodle"
    status, out, err = collect(system, dict.fromkeys(files, ONE), *arguments, roster=roster)
    assert status == bool(told) and err.count(told) == times
    assert f"{len(taken)} notebooks of {len(taken)} students" in out
    assert set(written(tmp_path)) == {f"{student}/{toy.NAME}/{FILE}" for student in taken}


def test_nothing_is_overwritten_unless_it_is_asked_for(tmp_path, collect):
    name = f"smithjohn_12345_678_{FILE}"
    collect("canvas", {name: ONE})
    (stamp := tmp_path / "in" / "jsmith" / toy.NAME / "timestamp.txt").write_text("2026-10-20")
    status, _, err = collect("canvas", {name: OTHER})
    assert status == 1 and f"differs from what in/jsmith/{toy.NAME} holds already" in err
    assert written(tmp_path)[f"jsmith/{toy.NAME}/{FILE}"] == ONE and stamp.exists()
    status, out, _ = collect("canvas", {f"twinal_8_3_{FILE}": ONE})
    assert "no notebook of 07-toy: 1 (ada@example.edu)" in out, "of who has one nothing is said"
    assert collect("canvas", {name: OTHER}, "--replace")[0] == 0
    del (there := written(tmp_path))[f"al/{toy.NAME}/{FILE}"]
    assert there == {f"jsmith/{toy.NAME}/{FILE}": OTHER}


def test_what_was_left_out_is_remembered_until_it_is_collected(tmp_path, collect):
    left = tmp_path / "in" / ".left-out.json"
    files = {f"smithjohn_99_678_{FILE}": ONE, f"twinal_8_3_{FILE}": ONE, "x_8_2_a.pdf": ONE}
    packed = {"lovelaceada_67_2_mine.ZIP": ONE}
    collect("canvas", files | packed)
    assert json.loads(left.read_text()) == dict.fromkeys([*packed, next(iter(files))], toy.NAME)
    left.write_text(json.dumps({next(iter(files)): toy.NAME}))
    collect("canvas", {f"lovelaceada_67_9_{FILE}": "{"})
    collect("canvas", {f"lovelaceada_67_9_{FILE}": ONE}, *NAMED)
    assert list(json.loads(left.read_text())) == [f"smithjohn_99_678_{FILE}"], "she has a notebook"
    assert collect("canvas", files, roster=CANVAS.replace("12345", "99"))[0] == 1
    assert not left.exists()
    left.write_text("[")
    assert collect("canvas", files).refused(".left-out.json cannot be read: delete it")


def test_a_link_in_the_way_is_not_followed(tmp_path, collect):
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "jsmith").symlink_to(tmp_path / "elsewhere")
    status, _, err = collect("canvas", {f"smithjohn_12345_678_{FILE}": ONE})
    assert status == 1 and "through a link" in err and not any((tmp_path / "elsewhere").iterdir())


@pytest.mark.parametrize(
    "name", [f"../{FILE}", f"/{FILE}", f"a/../../{FILE}", f"C:/{FILE}", f"..\\{FILE}"]
)
def test_a_path_that_leads_out_of_the_zip_refuses_all_of_it(tmp_path, collect, name):
    status, _, err = collect("canvas", {f"smithjohn_12345_678_{FILE}": ONE, name: ONE})
    assert status == 2 and "leads out of it" in err and written(tmp_path) == {}


def test_links_bombs_and_what_is_no_zip_are_refused(tmp_path, collect, autograder, monkeypatch):
    good = f"smithjohn_12345_678_{FILE}"
    monkeypatch.setattr(downloads, "MAX_BYTES", 1000)
    status, _, err = collect("canvas", {good: "0" * 10**6})
    assert status == 1 and f"{good} is larger than" in err
    monkeypatch.setattr(downloads, "MAX_TOTAL_BYTES", 999)
    assert "when it is unpacked" in collect("canvas", {good: "0" * 10**6})[2]
    link = zipfile.ZipInfo(good)
    link.external_attr = (stat.S_IFLNK | 0o777) << 16
    where = ("--format", "canvas", "--roster", "roster.csv", "--submitted", "in")
    with zipfile.ZipFile("link.zip", "w") as file:
        file.writestr(link, "/etc/passwd")
    assert "holds a link" in autograder("collect", "link.zip", *where)[2]
    Path("no.zip").write_text("no")
    for name, words in {"no.zip": "no.zip is no zip", "gone.zip": "cannot be read"}.items():
        assert autograder("collect", name, *where).refused(words)
    assert written(tmp_path) == {}


@pytest.mark.parametrize(
    ("roster", "arguments", "words"),
    [
        (CANVAS.splitlines()[0], [], "a header and students are wanted"),
        ("\n".join(CANVAS.splitlines()[:2]), [], "roster.csv has no student"),
        (CANVAS, ["--match", "Login"], "there is no column 'Login' for --match"),
        (CANVAS, ["--assignment", "08"], "has no assignment 08; it has 07-toy"),
    ],
)
def test_wrong_use_writes_nothing(tmp_path, collect, roster, arguments, words):
    status, out, err = collect("canvas", {f"s_8_1_{FILE}": ONE}, *arguments, roster=roster)
    assert (status, out) == (2, "") and words in err and written(tmp_path) == {}
