#!/usr/bin/env bash
# Whether the Debian packages of build/release/packages are good for others: lintian finds no error, and in a fresh
# Debian 12 (debootstrap, in CHROOT) they install with their declared dependencies alone and do what they are for.
# Needs root, lintian, debootstrap and the net: not part of the tests. Usage: check_packages.sh [CHROOT]
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/.."
chroot=${1:-build/chroot}
packages=build/release/packages
suite=bookworm
mirror=${DEBIAN_MIRROR:-http://deb.debian.org/debian}
((EUID == 0)) || { echo "check_packages: needs root" >&2; exit 1; }
for program in lintian debootstrap; do
  command -v "$program" >/dev/null || { echo "check_packages: $program is missing (apt install $program)" >&2; exit 1; }
done
compgen -G "$packages/*.deb" >/dev/null || { echo "check_packages: no packages; ./dev package makes them" >&2; exit 1; }

echo "== lintian"
lintian --fail-on error --allow-root "$packages"/*.deb

echo "== a fresh Debian"
begin=$SECONDS
if [[ ! -x $chroot/usr/bin/apt-get ]]; then
  debootstrap --variant=minbase "$suite" "$chroot" "$mirror"
  echo "debootstrap took $((SECONDS - begin)) s"
fi
in_chroot() { chroot "$chroot" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"; }
for name in proc sys dev; do mountpoint -q "$chroot/$name" || mount --bind "/$name" "$chroot/$name"; done
trap 'for name in proc sys dev; do umount -l "$chroot/$name"; done' EXIT
cp /etc/resolv.conf "$chroot/etc/"
for settings in /etc/apt/apt.conf.d/*proxy*; do [[ -f $settings ]] && cp "$settings" "$chroot/etc/apt/apt.conf.d/"; done
in_chroot apt-get update -qq
rm -rf "$chroot/packages" && cp -r "$packages" "$chroot/packages"

# install WHAT FILE…: with what it declares and no recommendation, and the time and size of that.
install() {
  local what=$1 begin=$SECONDS before after
  shift
  before=$(in_chroot sh -c "dpkg-query -W -f='\${Installed-Size}\n'" | awk '{sum += $1} END {print sum}')
  in_chroot apt-get install -y -qq --no-install-recommends "$@" >"$chroot/install.log" 2>&1 || { tail -20 "$chroot/install.log"; exit 1; }
  after=$(in_chroot sh -c "dpkg-query -W -f='\${Installed-Size}\n'" | awk '{sum += $1} END {print sum}')
  echo "$what: installed in $((SECONDS - begin)) s, $(((after - before) / 1024)) MiB with all that it depends on"
}
in_package() { in_chroot sh -c "ls /packages/$1_*.deb"; }

echo "== plumbline"
install plumbline "$(in_package plumbline)"
begin=$SECONDS
in_chroot sh -c 'cd /root && plumbline demo -o demo --frames 40' | tail -3
echo "plumbline demo took $((SECONDS - begin)) s"
in_chroot test -s /root/demo/report.html
in_chroot sh -c 'test -s /usr/share/man/man1/plumbline.1.gz && test -s /usr/share/bash-completion/completions/plumbline'

echo "== python3-plumbline"
install python3-plumbline "$(in_package python3-plumbline)"
begin=$SECONDS
cp -r examples "$chroot/root/"
in_chroot sh -c 'cd /root && python3 examples/compare_settings.py demo/sequence && python3 examples/live_camera.py demo/sequence 4 | tail -1'
echo "the Python examples took $((SECONDS - begin)) s"

echo "== libplumbline-dev"
install libplumbline-dev "$(in_package 'libplumbline0*')" "$(in_package libplumbline-dev)" g++ cmake make
in_chroot sh -c 'cd /root && cmake -S examples -B build >/dev/null && cmake --build build >/dev/null && build/reconstruct demo/sequence'
echo "== sizes"
ls -l --block-size=K "$packages"/*.deb | awk '{print $5, $NF}'
