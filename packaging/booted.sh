#!/usr/bin/env bash
# Boots a machine with systemd and the Debian package, and tests that systemd starts, supervises and
# restarts the chain. Needs root, systemd-nspawn (Debian's systemd-container) and debootstrap.
#   packaging/booted.sh [FOLDER OF A DEBIAN WITH systemd, if there is one]
set -euo pipefail
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf --one-file-system "$work"' EXIT
machine=$work/machine
if [ $# -gt 0 ]; then
    cp -a "$1" "$machine"
else
    debootstrap --variant=minbase --include=systemd,systemd-sysv,dbus bookworm "$machine" >"$work/log" || { cat "$work/log"; exit 1; }
fi
cp target/packaging/lariat_*.deb "$machine/srv/"
chroot "$machine" sh -c 'dpkg --install /srv/lariat_*.deb' >/dev/null

cat >"$machine/srv/check" <<'CHECK'
#!/bin/bash
# Script that the machine runs after booting. It ends with the machine, and prints `well` if
# everything passed.
exec >/srv/said 2>&1
trap 'systemctl poweroff' EXIT
set -ex
lariat service install --rig cell
as_lariat() { runuser --user lariat -- env --chdir=/ "$@"; }
is_again() {
    [ "$(systemctl show --property NRestarts --value lariat@cell)" = 1 ] && systemctl is-active --quiet lariat@cell
}
# The command returns when the chain is up.
systemctl start lariat@cell
as_lariat lariat topic hz --rig cell --duration 2s
systemctl status --no-pager lariat@cell
# After being killed, the chain is restarted and can be read again.
systemctl kill --kill-whom=main --signal=KILL lariat@cell
export -f is_again
timeout 30 bash -c 'until is_again; do sleep 0.2; done'
as_lariat lariat topic hz --rig cell --duration 2s
# Invalid settings are reported, and the start is not repeated.
systemctl stop lariat@cell
ls -A /dev/shm
[ -z "$(ls -A /dev/shm)" ]
echo 'order = "none"' >/etc/lariat/cell.toml
! systemctl start lariat@cell
journalctl --no-pager --unit lariat@cell | grep 'outside any section'
[ "$(systemctl is-failed lariat@cell)" = failed ]
lariat service uninstall --rig cell
[ -e /etc/lariat/cell.toml ]
echo well
CHECK
chmod +x "$machine/srv/check"
cat >"$machine/etc/systemd/system/check.service" <<'UNIT'
[Service]
Type=oneshot
ExecStart=/srv/check
[Install]
WantedBy=multi-user.target
UNIT
chroot "$machine" systemctl --quiet enable check.service
timeout 180 systemd-nspawn --quiet --register=no --keep-unit --boot --directory "$machine" </dev/null >"$work/boot" 2>&1 || cat "$work/boot"
cat "$machine/srv/said"
grep --quiet --line-regexp well "$machine/srv/said"
