# shellcheck shell=bash disable=SC2154
# Debian's own kernel and its drivers, for a guest that boots it. Sourced by guest_image.sh and installed_image.sh, which set
#   source_dir, out    this tree; where logs go
#   modules            what is loaded by name; what these depend on comes along, and what a kernel has built in is no module
# and define fail. The kernel package is downloaded once into ${NINEDOT_CACHE:-/var/tmp/ninedot-cache}/hil.
cache=${NINEDOT_CACHE:-/var/tmp/ninedot-cache}/hil
mkdir -p "$cache"
PATH=$PATH:/usr/sbin:/sbin

kernel_package() {
  apt-cache depends --important linux-image-amd64 2> /dev/null | sed -n 's/^ *Depends: \(linux-image-[0-9].*\)/\1/p' | head -n 1
}

# The lists of a bare machine may be missing or older than the archive.
refresh_lists() {
  local sudo=()
  [[ $EUID -eq 0 ]] || sudo=(sudo -n)
  "${sudo[@]}" apt-get -q -o DPkg::Lock::Timeout=300 update > "$out/apt.log" 2>&1 || true
}

# The kernel's package unpacked, as $cache/linux-image-VERSION. A part of it never looks like the whole: it is moved there at the end.
fetch_kernel() {
  local package part
  package=$(kernel_package)
  [[ -n $package ]] || { refresh_lists; package=$(kernel_package); }
  [[ -n $package ]] || fail "apt knows no linux-image-amd64: put Debian's main archive into its sources"
  kernel=$cache/$package
  [[ -e $kernel/complete ]] && return
  echo "downloading $package"
  part=$(mktemp -d "$cache/part.XXXXXX")
  (cd "$part" && { apt-get -q download "$package" > "$out/apt.log" 2>&1 || { refresh_lists; apt-get -q download "$package" >> "$out/apt.log" 2>&1; }; }) ||
    fail "$package can't be downloaded; what apt-get said is in $out/apt.log"
  mkdir "$part/root"
  dpkg -x "$part"/*.deb "$part/root"
  rm "$part"/*.deb
  [[ -d $part/root/lib ]] || ln -s usr/lib "$part/root/lib"
  # Debian 13 compresses its modules, and busybox can't load those.
  find "$part/root/lib/" -name '*.ko.xz' -exec xz -d {} +
  touch "$part/root/complete"
  depmod -b "$part/root" "$(basename "$part"/root/lib/modules/*)" 2> /dev/null
  mv -T "$part/root" "$kernel" 2> /dev/null || [[ -e $kernel/complete ]]  # somebody else may have been faster
  rm -rf "$part"
}

# copy_modules ROOT: the modules into ROOT/lib/modules.
copy_modules() {
  local root=$1 version module path
  version=$(basename "$kernel"/lib/modules/*)
  for module in "${modules[@]}"; do
    modprobe -d "$kernel" -S "$version" --show-depends "$module" | sed -n 's/^insmod \([^ ]*\).*/\1/p'
  done | sort -u | while read -r path; do
    path=${path#"$kernel"}
    install -D -m 644 "$kernel$path" "$root$path"
  done
  cp "$kernel/lib/modules/$version/"modules.{order,builtin,builtin.modinfo} "$root/lib/modules/$version/" 2> /dev/null || true
  depmod -b "$root" "$version" 2> /dev/null
}

# Drivers of simulated hardware, built once for this kernel.
add_simulated_hardware() {
  "$source_dir/tests/hil/kernel_modules.sh" "$kernel" "$out/modules.log"
  modules+=(i2c-stub i2c-dev configfs gpio-sim pwm-pca9685)
}
