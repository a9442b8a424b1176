#!/bin/sh
# The pictures of docs/calibrating.md, anew: tests/bench/calibrating_pictures.sh (after `./dev bench` has built the tools).
set -eu
cd "$(dirname "$0")/../.."
bin=build/release/bin
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$bin/bench_calibrate" --save "$folder/walk" --lens barrel --views 60
cp "$folder/walk/views.png" docs/calibrating-views.png
"$bin/ninedot" calibrate camera "$folder/walk" --out "$folder/camera.yaml" --picture docs/calibrating.svg
cat "$folder/camera.yaml"
