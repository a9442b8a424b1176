#!/bin/busybox sh
# The guest's first process: mounts, network, then a shell that the host drives through the virtual console.
/bin/busybox --install -s /bin
export PATH=/bin HOME=/ TERM=dumb
mount -t proc proc /proc
mount -t sysfs sysfs /sys
mount -t devtmpfs dev /dev
mkdir -p /dev/pts /dev/shm
mount -t devpts devpts /dev/pts
mount -t tmpfs tmpfs /tmp
mount -t debugfs debugfs /sys/kernel/debug
ip link set lo up
for module in virtio_pci virtio_console virtio_net; do modprobe $module || echo "init: no $module"; done
ip addr add 10.0.2.15/24 dev eth0 && ip link set eth0 up && ip route add default via 10.0.2.2
httpd -p 8080 -h /
for _ in 1 2 3 4 5 6 7 8 9 10; do [ -e /dev/hvc0 ] && break; sleep 0.2; done
# A shell whose output is a terminal would prompt and echo; what the host wants to see is written to descriptor 3.
exec 3<> /dev/hvc0
stty raw -echo <&3
echo "init: ready"
sh <&3 > /dev/null 2>&1
echo "init: over"
poweroff -f
