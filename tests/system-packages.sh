#!/bin/sh
# The Debian packages that some tests need. `system-packages.sh plan DEPTH` says which are missing and
# what will be done about it; `system-packages.sh install DEPTH` does it, where it may.
# It never fails: a test that cannot run says so, and STRICT=1 makes that an error.
missing=
command -v chromium-headless-shell >/dev/null 2>&1 || command -v chromium >/dev/null 2>&1 ||
    missing="chromium-headless-shell"
if [ "$2" != test ]; then
    command -v gpg >/dev/null 2>&1 || missing="$missing gnupg"
    ls /usr/lib/postgresql/*/bin/initdb >/dev/null 2>&1 || missing="$missing postgresql"
    command -v firefox-esr >/dev/null 2>&1 || missing="$missing firefox-esr"
fi
missing=${missing# }
[ -n "$missing" ] || exit 0

run=
if [ "$(id -u)" -ne 0 ]; then
    if sudo -n true 2>/dev/null; then run="sudo -n"; else run=no; fi
fi
command -v apt-get >/dev/null 2>&1 || run=no
if [ "$1" = plan ]; then
    if [ "$run" = no ]; then
        echo "Missing: $missing. Tests that need them are left out; install them with:"
        echo "  sudo apt-get install $missing"
    else
        echo "It installs with apt, because some tests need them: $missing"
    fi
    exit 0
fi
[ "$run" != no ] || exit 0
export DEBIAN_FRONTEND=noninteractive
# Tests start a server of their own; Debian's package would start another, for good.
no_server=/etc/postgresql-common/createcluster.d/tests.conf
case $missing in *postgresql*)
    $run mkdir -p "${no_server%/*}"
    echo 'create_main_cluster = false' | $run tee "$no_server" >/dev/null ;;
esac
# shellcheck disable=SC2086 # the words of $run and $missing are meant to split
{ $run apt-get update -qq && $run apt-get install -y -qq --no-install-recommends $missing; } \
    >/dev/null || echo "apt could not install $missing; the tests that need them are left out."
$run rm -f "$no_server"
exit 0
