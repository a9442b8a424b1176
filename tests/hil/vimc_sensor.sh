#!/bin/bash
# Gives vimc, the kernel's test camera with a media graph, what the tests need of it, in its sources before they are built. Sensor A and its way to
# Raw Capture 0 stay as they are. Sensor B becomes a monochrome sensor: its links can be switched, and it has the controls of
# drivers/media/i2c/ov9282.c, with the same dependence of the exposure's range on the blanking, which makes vimc's frame rate.
#
#   tests/hil/vimc_sensor.sh FOLDER      FOLDER: vimc's sources of Linux 6.1 or 6.12
set -euo pipefail
fail() { echo "vimc_sensor.sh: $*" >&2; exit 2; }
[[ $# -eq 1 && -e $1/vimc-sensor.c ]] || fail "usage: tests/hil/vimc_sensor.sh FOLDER"
cd "$1"

# change FILE TEXT SED-SCRIPT: TEXT is what has to be there afterwards; a kernel that says it otherwise is told at once.
change() {
  sed -i "$3" "$1"
  grep -qF -- "$2" "$1" || fail "$1 is not as expected: no '$2' came of it"
}

# Neither of Sensor B's links is on, and both can be.
change vimc-core.c 'SENSOR_B, 0, RAW_CAPTURE_1, 0, 0)' '/VIMC_DATA_LINK(SENSOR_B, 0, \(DEBAYER_B\|RAW_CAPTURE_1\), 0,$/{N; s/,\n.*/, 0),/}'
# 8 and 10 bits of grey, which the pattern generator can draw and vimc has no line for.
change vimc-common.c MEDIA_BUS_FMT_Y10_1X10 's|^\t/\* RGB formats \*/$|\t{ .code = { MEDIA_BUS_FMT_Y8_1X8 }, .pixelformat = V4L2_PIX_FMT_GREY, .bpp = 1 },\
\t{ .code = { MEDIA_BUS_FMT_Y10_1X10 }, .pixelformat = V4L2_PIX_FMT_Y10, .bpp = 2 },\
&|'
change vimc-streamer.c vimc_period_us 's|schedule_timeout(HZ / 60)|schedule_timeout(usecs_to_jiffies(vimc_period_us))|
s|^static int vimc_streamer_thread|extern unsigned int vimc_period_us;\n&|'
cat > mono.part << 'end'
unsigned int vimc_period_us = 16667;
static struct v4l2_ctrl *mono_exposure;

/* A mode of 640 x 480 pixels: lines of 640 + 890 at 200 MHz. */
static int mono_s_ctrl(struct v4l2_ctrl *ctrl)
{
	if (ctrl->id != V4L2_CID_VBLANK)
		return 0;
	vimc_period_us = (480 + ctrl->val) * (640 + 890) / 200;
	/* Refused where the default is out of the range, and as ov9282.c without power this says nothing of it. */
	__v4l2_ctrl_modify_range(mono_exposure, 1, 480 + ctrl->val - 25, 1, 642);
	return 0;
}

static const struct v4l2_ctrl_ops mono_ctrl_ops = {
	.s_ctrl = mono_s_ctrl,
};

static void mono_add_controls(struct v4l2_ctrl_handler *hdl)
{
	mono_exposure = v4l2_ctrl_new_std(hdl, &mono_ctrl_ops, V4L2_CID_EXPOSURE, 1, 1477, 1, 642);
	v4l2_ctrl_new_std(hdl, &mono_ctrl_ops, V4L2_CID_ANALOGUE_GAIN, 16, 255, 1, 16);
	v4l2_ctrl_new_std(hdl, &mono_ctrl_ops, V4L2_CID_VBLANK, 22, 51540, 1, 1022);
	v4l2_ctrl_new_std(hdl, &mono_ctrl_ops, V4L2_CID_HBLANK, 890, 32127, 1, 890);
	v4l2_ctrl_new_std(hdl, NULL, V4L2_CID_PIXEL_RATE, 200000000, 200000000, 1, 200000000);
}

end
change vimc-sensor.c mono_add_controls '/^static struct vimc_ent_device \*vimc_sensor_add/e cat mono.part'
change vimc-sensor.c 'mono_add_controls(&vsensor->hdl)' '/V4L2_CID_SATURATION, 0, 255, 1, 128);/a \
\tif (!strcmp(vcfg_name, "Sensor B"))\
\t\tmono_add_controls(\&vsensor->hdl);'
rm mono.part
