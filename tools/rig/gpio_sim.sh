# gpio_sim.sh: Debian's stock kernel with a GPIO chip that is simulated. Sourced by run.
#
# The kernel comes from its package, unpacked and not installed. Debian builds no gpio-sim; the module is made
# from linux-source's gpio-sim.c together with irq_sim.c, which Debian leaves out too.

# the release that linux-image-amd64 stands for, such as 6.1.0-13-amd64
kernel_release() {
  apt-cache depends linux-image-amd64 2>/dev/null | sed -n 's/.*Depends: linux-image-//p' | head -n 1
}

guest_modules='can can-raw can-dev vcan vxcan slcan virtio virtio_ring virtio_pci virtio_pci_legacy_dev
  virtio_pci_modern_dev 9pnet 9pnet_virtio 9p netfs fscache configfs'

# only what the guest loads is kept: the kernel, and a handful of modules
fetch_kernel() {
  local release=$1 name file
  [ ! -d "$cache/kernel" ] || return 0
  unpack kernel-whole "linux-image-$release"
  mkdir -p "$cache/tmp-kernel/modules"
  cp "$cache/kernel-whole/boot/vmlinuz-$release" "$cache/tmp-kernel/vmlinuz"
  for name in $guest_modules; do
    file=$(find "$cache/kernel-whole/lib/modules" -name "$name.ko*" | head -n 1)
    [ -z "$file" ] || cp "$file" "$cache/tmp-kernel/modules/"
  done
  mv "$cache/tmp-kernel" "$cache/kernel"
  rm -rf "$cache/kernel-whole"
}

# kbuild for modules outside the tree, from the unpacked headers
fetch_headers() {
  local release=$1 folder
  [ ! -d "$cache/headers" ] || return 0
  # shellcheck disable=SC2046
  unpack headers-new "linux-headers-$release" \
    $(apt-cache depends "linux-headers-$release" | sed -n 's/.*Depends: \(linux-headers-\|linux-kbuild-\)/\1/p')
  folder=$cache/headers/usr/src
  echo "include $folder/linux-headers-${release%-*}-common/Makefile" \
    >"$cache/headers-new/usr/src/linux-headers-$release/Makefile"
  mv "$cache/headers-new" "$cache/headers"
}

build_gpio_sim() {
  local release=$1 folder=$cache/tmp-gpio-sim series
  [ ! -e "$cache/gpio-sim.ko" ] || return 0
  series=$(echo "$release" | cut -d . -f 1-2)
  unpack source "linux-source-$series"
  say "building gpio-sim"
  rm -rf "$folder"
  mkdir -p "$folder"
  tar -xf "$cache/source/usr/src/linux-source-$series.tar.xz" -C "$folder" --strip-components=3 --wildcards \
    '*/drivers/gpio/gpio-sim.c' '*/drivers/gpio/gpiolib.h' '*/kernel/irq/irq_sim.c'
  mv "$folder/gpio-sim.c" "$folder/gpio-sim-main.c"
  # the one symbol that the kernel does not export to modules
  sed -i 's/handle_simple_irq(irq_to_desc(irqnum))/generic_handle_irq(irqnum)/' "$folder/irq_sim.c"
  printf 'obj-m := gpio-sim.o\ngpio-sim-y := gpio-sim-main.o irq_sim.o\n' >"$folder/Makefile"
  make -s -C "$cache/headers/usr/src/linux-headers-$release" M="$folder" modules >"$folder/log" 2>&1 ||
    die "gpio-sim cannot be built: $(tail -n 3 "$folder/log")"
  mv "$folder/gpio-sim.ko" "$cache/"
  rm -rf "$folder" "$cache/source"
}

# libgpiod 2 and a talus-acquire that is built with it, where this release's own is 1
fetch_gpiod2() {
  local library
  unpack_backports gpiod2 libgpiod-dev libgpiod3
  library=$(dirname "$(find "$cache/gpiod2/usr/lib" -name 'libgpiod.so.3' | head -n 1)")
  make -s --no-print-directory -C "$root" BUILD="${TALUS_BUILD:-$root/build}/gpiod2" GPIOD=2 \
    GPIOD_FLAGS="-DTALUS_GPIOD=2 -I$cache/gpiod2/usr/include" \
    GPIOD_LIBS="-L$library -Wl,-rpath,$library -l:libgpiod.so.3" \
    "${TALUS_BUILD:-$root/build}/gpiod2/bin/talus-acquire" >/dev/null
}

fetch_gpio() {
  local release
  release=$(kernel_release)
  [ -n "$release" ] || die "apt knows no linux-image-amd64"
  mkdir -p "$cache"
  # kernel, headers and module belong together: anew for another release, or after a fetch that was cut off
  [ "$(cat "$cache/release" 2>/dev/null)" = "$release" ] ||
    rm -rf "$cache"/{kernel,kernel-whole,headers,headers-new,source,gpio-sim.ko,release}
  unpack busybox busybox-static
  fetch_kernel "$release"
  fetch_headers "$release"
  build_gpio_sim "$release"
  echo "$release" >"$cache/release"
  fetch_gpiod2
}

# ---- QEMU -------------------------------------------------------------------------

# an initramfs of busybox and the modules, in the order in which they are to be loaded
make_initramfs() { # make_initramfs FOLDER
  local tree=$1/initramfs busybox=$cache/busybox/bin/busybox
  mkdir -p "$tree"/{bin,modules,proc,sys,dev,root}
  cp "$busybox" "$tree/bin/"
  cp "$cache"/kernel/modules/* "$cache/gpio-sim.ko" "$tree/modules/"
  sed "s|@FOLDER@|$1|" "$here/qemu_init" >"$tree/init"
  chmod +x "$tree/init"
  (cd "$tree" && find . | "$busybox" cpio -o -H newc 2>/dev/null) >"$1/initramfs.cpio"
}

# One processor: with two, edges in quick succession can meet in the simulated interrupt and become one.
in_qemu() {
  local folder
  [ "$(uname -m)" = x86_64 ] || die "the QEMU guest is made for x86_64 only"
  command -v qemu-system-x86_64 >/dev/null || die 'qemu-system-x86_64 is missing; `tools/setup rig` installs it'
  fetch_gpio
  folder=$(mktemp -d)
  write_command "$folder/command" "$@"
  make_initramfs "$folder"
  qemu-system-x86_64 -M q35 -accel tcg -smp 1 -m 1024 -nographic -no-reboot -nic none \
    -kernel "$cache/kernel/vmlinuz" -initrd "$folder/initramfs.cpio" \
    -append 'console=ttyS0 quiet loglevel=1 panic=-1 mitigations=off' \
    -virtfs local,path=/,mount_tag=machine,security_model=none,multidevs=remap \
    </dev/null 2>&1 | guest_words "$folder" || true
  finish_guest "$folder"
}
