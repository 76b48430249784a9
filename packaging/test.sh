#!/usr/bin/env bash
# Installs and uses the artifacts of packaging/build.sh: the Debian packages in a bare Debian, by
# the steps of the Containerfile; the wheel in a new Python environment; and both together, as a
# container and a program outside it. Needs root, debootstrap, unshare, and python3 with venv.
#   packaging/test.sh [FOLDER OF A BARE DEBIAN, if there is one]
set -euo pipefail
cd "$(dirname "$0")/.."
out=$PWD/target/packaging
if [ -z "${LARIAT_APART:-}" ]; then
    # A separate mount namespace, which ends with the script.
    LARIAT_APART=1 exec unshare --mount "$0" "$@"
fi
work=$(mktemp -d)
trap 'umount -R "$work"/image/* 2>/dev/null || true; rm -rf --one-file-system "$work" /tmp/lariat-pack-{deb,wheel,both}' EXIT
say() { printf '\n== %s\n' "$*"; }
fail() { echo "packaging/test.sh: $*" >&2; exit 1; }
image=$work/image

say "a bare Debian"
if [ $# -gt 0 ]; then
    cp -a "$1" "$image"
else
    debootstrap --variant=minbase bookworm "$image" >"$work/log" || { cat "$work/log"; exit 1; }
fi
mount -t proc proc "$image/proc"
mount --bind /tmp "$image/tmp"
mount --bind /dev "$image/dev"
mount --bind /dev/shm "$image/dev/shm"

say "the steps of the Containerfile"
user=0 entry=
while read -r step words; do
    case $step in
    COPY)
        read -r from to <<<"$words"
        # shellcheck disable=SC2086  # names with a star
        cp "$out"/$from "$image$to"
        ;;
    RUN) time chroot "$image" sh -ec "$words" ;;
    USER) user=$words ;;
    ENTRYPOINT) entry=$(tr -d '[]"' <<<"$words") ;;
    esac
done < <(grep -v '^#' packaging/Containerfile)
inside() { env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LARIAT_DOMAIN="$LARIAT_DOMAIN" chroot --userspec="$user:$user" "$image" "$@"; }

say "the package, used"
export LARIAT_DOMAIN=pack-deb
inside "$entry" --version
inside "$entry" run --frames 100 --fps max --lossless 2>&1 | grep '^100 frames received'
cp docs/rope.png "$image/srv/"
inside "$entry" trace /srv/rope.png | grep 'rope.png *0 *ok'
# The program is found and reports the error itself.
{ inside "$entry" compare /nowhere /nowhere 2>&1 || true; } | grep '/nowhere cannot be read'
for file in man1/lariat.1.gz man1/lariat-run.1.gz; do gzip -t "$image/usr/share/man/$file"; done
bash -n "$image/usr/share/bash-completion/completions/lariat"
chroot "$image" getent passwd lariat
grep -q '^ExecStart=/usr/bin/lariat run' "$image/usr/lib/systemd/system/lariat@.service"
chroot "$image" lariat service install --rig cell | tee "$work/said"
grep -q "the package's unit" "$work/said"
chroot "$image" lariat config check /etc/lariat/cell.toml

say "the package of lariat ros2, beside it"
cp "$out"/lariat-ros2_*.deb "$image/srv/"
chroot "$image" sh -ec 'dpkg --install /srv/lariat-ros2_*.deb'
# The program is found and reports the error itself.
{ inside "$entry" ros2 --domain-id 999 2>&1 || true; } | grep 'the domain 999 is too large'

say "the wheel, in a new environment"
export LARIAT_DOMAIN=pack-wheel
python3 -m venv "$work/python"
time "$work/python/bin/pip" install --quiet "$out"/lariat-*.whl
"$work/python/bin/lariat" --version
"$work/python/bin/lariat" run --frames 100 --fps max --lossless 2>&1 | grep '^100 frames received'
{ "$work/python/bin/lariat" compare /nowhere /nowhere 2>&1 || true; } | grep '/nowhere cannot be read'
"$work/python/bin/python" - <<'PYTHON'
import lariat
print(lariat.__file__)
PYTHON

say "a chain in the container, read outside it"
export LARIAT_DOMAIN=pack-both
# A domain belongs to one user: here, the user who runs the test.
user=$(id -u)
inside "$entry" run --fps 30 --duration 10s --quiet >"$work/chain" 2>&1 &
chain=$!
"$work/python/bin/python" - <<'PYTHON'
import lariat, time
deadline = time.monotonic() + 10
with lariat.Reader() as reader:
    for frame in reader:
        if isinstance(frame.only_rope(max_age=1), lariat.Fresh):
            print("a rope")
            break
        assert time.monotonic() < deadline, "no rope was seen within 10 s"
PYTHON
wait "$chain" || fail "the chain failed: $(cat "$work/chain")"

say "taken away again"
chroot "$image" dpkg --remove lariat-ros2 lariat
for path in usr/bin/lariat usr/bin/lariat-top usr/bin/lariat-bench usr/bin/lariat-ros2 usr/lib/systemd/system/lariat@.service usr/share/man/man1/lariat.1.gz; do
    [ ! -e "$image/$path" ] || fail "$path is left"
done
[ -e "$image/etc/lariat/cell.toml" ] || fail "the settings are gone"
left=$(ls /dev/shm | grep lariat_pack- || true)
[ -z "$left" ] || fail "left in /dev/shm: $left"
say "all is well"
