#!/bin/sh
# Installs the Debian packages that some tests need, where they are missing and it may.
# It never fails: a test that cannot run says so, and STRICT=1 makes that an error.
missing=
command -v chromium >/dev/null 2>&1 || missing="chromium"
command -v bwrap >/dev/null 2>&1 || missing="$missing bubblewrap"
command -v gpg >/dev/null 2>&1 || missing="$missing gnupg"
ls /usr/lib/postgresql/*/bin/initdb >/dev/null 2>&1 || missing="$missing postgresql"
[ -n "$missing" ] || exit 0

run=
if [ "$(id -u)" -ne 0 ]; then
    if sudo -n true 2>/dev/null; then run="sudo -n"; else run=no; fi
fi
if [ "$run" = no ] || ! command -v apt-get >/dev/null 2>&1; then
    echo "Missing:$missing. Tests that need them are left out;" \
        "install with: sudo apt-get install $missing"
    exit 0
fi
echo "Installing with apt: $missing"
export DEBIAN_FRONTEND=noninteractive
# Tests start a server of their own; Debian's package would start another, for good.
no_server=/etc/postgresql-common/createcluster.d/tests.conf
case $missing in *postgresql*)
    $run mkdir -p "${no_server%/*}"
    echo 'create_main_cluster = false' | $run tee "$no_server" >/dev/null ;;
esac
# shellcheck disable=SC2086 # the words of $run and $missing are meant to split
{ $run apt-get update -qq && $run apt-get install -y -qq --no-install-recommends $missing; } \
    >/dev/null || echo "apt could not install$missing; the tests that need it are left out."
$run rm -f "$no_server"
exit 0
