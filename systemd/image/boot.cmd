# U-Boot's script: which of the two systems starts. BOOT_ORDER says who comes first, BOOT_A_LEFT and BOOT_B_LEFT how many starts each has before the
# other one's turn; RAUC sets them (toolchains/image.sh, docs/board.md).
#
# The three live on the disk itself, before the first partition, in two copies as fw_setenv writes them: CRC (4 bytes), a count of writings (1), text.
# Debian's U-Boot keeps its own variables in one copy that a power cut can halve, and elsewhere on each board; so the script reads and writes these, always
# the older copy. Numbers are hexadecimal; a block has 512 bytes.
setexpr kernel_at ${kernel_addr_r} + 8000000
setexpr initrd_at ${kernel_at} + 4000000
setexpr copy1_at ${kernel_at} - 1000000
setexpr copy2_at ${copy1_at} + 100000
setexpr state_at ${copy2_at} + 100000
setexpr state_text ${state_at} + 4
${devtype} dev ${devnum}

# A copy that can't be read must not be taken for one that was.
mw.b ${copy1_at} ff 4000
mw.b ${copy2_at} ff 4000
${devtype} read ${copy1_at} 800 20
${devtype} read ${copy2_at} 1000 20
setexpr at ${copy1_at} + 4
setexpr.b count1 *${at}
setexpr at ${copy2_at} + 4
setexpr.b count2 *${at}

# The newer one is taken over last; what has a wrong CRC is not taken over. fw_printenv's rule: equal counts mean the first, 0 comes after ff.
setenv copies "1 2"
if itest ${count2} -le ${count1}; then setenv copies "2 1"; fi
if itest ${count1} -eq ff && itest ${count2} -eq 0; then setenv copies "1 2"; fi
if itest ${count2} -eq ff && itest ${count1} -eq 0; then setenv copies "2 1"; fi
setenv BOOT_ORDER "A B"
setenv BOOT_A_LEFT 9
setenv BOOT_B_LEFT 9
setenv valid 0
for copy in ${copies}; do
  if test ${copy} = 1; then setenv at ${copy1_at}; else setenv at ${copy2_at}; fi
  cp.b ${at} ${state_at} 4
  setexpr at ${at} + 5
  cp.b ${at} ${state_text} 3ffb
  if env import -c ${state_at} 3fff BOOT_ORDER BOOT_A_LEFT BOOT_B_LEFT; then setenv valid ${copy}; fi
done

setenv save_state '
env export -c -s 3fff ${state_at} BOOT_ORDER BOOT_A_LEFT BOOT_B_LEFT;
cp.b ${state_at} ${copy1_at} 4;
setexpr at ${copy1_at} + 4; mw.b ${at} ${count} 1;
setexpr at ${copy1_at} + 5; cp.b ${state_text} ${at} 3ffb;
${devtype} write ${copy1_at} ${block} 20'
if test ${valid} = 1; then
  setenv block 1000
  setexpr count ${count1} + 1
elif test ${valid} = 2; then
  setenv block 800
  setexpr count ${count2} + 1
else
  echo "ninedot: no copy of the variables is whole: begins anew"
  setenv block 800
  setenv count 1
fi

setenv slot
for candidate in ${BOOT_ORDER}; do
  if test -n "${slot}"; then
    true
  elif test "${candidate}" = A && itest ${BOOT_A_LEFT} -gt 0; then
    setenv slot A
    setenv left ${BOOT_A_LEFT}
    setexpr BOOT_A_LEFT ${BOOT_A_LEFT} - 1
    setenv root_part 2
    setenv boot_part 6
  elif test "${candidate}" = B && itest ${BOOT_B_LEFT} -gt 0; then
    setenv slot B
    setenv left ${BOOT_B_LEFT}
    setexpr BOOT_B_LEFT ${BOOT_B_LEFT} - 1
    setenv root_part 5
    setenv boot_part 7
  fi
done
if test -z "${slot}"; then
  echo "ninedot: no system has starts left: both get new ones"
  setenv BOOT_ORDER "A B"
  setenv BOOT_A_LEFT 9
  setenv BOOT_B_LEFT 9
  run save_state
  sleep 2
  reset
fi
run save_state

# A confirmed system has nine starts; one of the last two is on trial: it has to prove itself in time (confirm-slot).
setenv trial
if itest ${left} -le 2; then setenv trial " ninedot.trial"; fi
setenv bootargs
if fdt addr ${fdt_addr}; then fdt get value bootargs /chosen bootargs; fi
if test -z "${bootargs}"; then setenv bootargs "ro quiet panic=10 systemd.gpt_auto=0"; fi
setenv bootargs "${bootargs} root=PARTUUID=39444f54-0${root_part} rauc.slot=${slot}${trial}"
echo "ninedot: system ${slot}, starts left before this one: ${left}; ${bootargs}"
if load ${devtype} ${devnum}:${boot_part} ${kernel_at} vmlinuz && load ${devtype} ${devnum}:${boot_part} ${initrd_at} initrd.gz; then
  booti ${kernel_at} ${initrd_at}:${filesize} ${fdt_addr}
fi

echo "ninedot: system ${slot} cannot be started"
setenv BOOT_${slot}_LEFT 0
if test ${block} = 800; then setenv block 1000; else setenv block 800; fi
setexpr count ${count} + 1
run save_state
sleep 2
reset
