#!/bin/bash
# Gathers the photographs of the Debian packages of the set `trust` (toolchains/packages.txt) for the program `trust`.
#   tests/bench/trust/photographs.sh FOLDER
# JPEG and opaque PNG files become links; what the project does not read itself (WebP, JPEG XL, AVIF, SVG, pictures with
# transparent parts, 16 bits) is turned into PGM by ffmpeg, on white. What is there already is left as it is.
set -euo pipefail
folder=${1:?usage: photographs.sh FOLDER}
here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
mkdir -p "$folder"
folder=$(readlink -f "$folder")

# Bytes of the smallest file: smaller ones are icons.
smallest=8000

# gather PACKAGE: "NAME TAB FILE" of its pictures. Of a wallpaper in several sizes (1920x1080.jpg) the largest one alone.
gather() {
  # Manuals repeat their pictures in every language.
  dpkg -L "$1" | { grep -iE '\.(jpe?g|png|webp|jxl|avif|svg|tiff?)$' || true; } | { grep -v /doc/HTML/ || true; } |
    xargs -r -d '\n' stat -c '%F:%s:%n' |
    awk -F : -v package="$1" -v smallest="$smallest" '$1 == "regular file" && $2 >= smallest {
      file = substr($0, length($1 $2) + 3)
      name = file; sub("^/usr/share/", "", name); sub("\\.[^.]*$", "", name)
      area = 0
      if (match(name, "/[0-9]+x[0-9]+$")) {
        split(substr(name, RSTART + 1), side, "x"); area = side[1] * side[2]
        name = substr(name, 1, RSTART - 1)
      }
      if (name in largest && largest[name] >= area) next
      largest[name] = area; files[name] = file
    }
    END { for (name in files) { safe = name; gsub(/[^A-Za-z0-9.-]/, "_", safe); print package "--" safe "\t" files[name] } }' | sort
}

# take NAME FILE
take() {
  local name=$1 file=$2 kind
  case ${file,,} in
    *.jpg | *.jpeg) ln -sf "$file" "$folder/$name.jpg"; return ;;
    *.png)
      kind=$(od -An -tu1 -j24 -N2 "$file")  # bits per channel, colour type: 0 grey, 2 RGB, else a palette or alpha
      if [[ $kind =~ ^\ +8\ +[02]$ ]]; then ln -sf "$file" "$folder/$name.png"; return; fi ;;
  esac
  [[ ! -s $folder/$name.pgm ]] || return 0
  # On white: 255 - alpha (255 - grey). One SVG keeps ffmpeg busy for ten minutes.
  timeout 30 ffmpeg -v error -nostdin -y -threads 1 -i "$file" -frames:v 1 \
    -vf "scale='min(4096,iw)':-1:flags=area,format=gbrap,negate,premultiply=inplace=1,format=gbrp,negate,format=gray" \
    -f image2 -c:v pgm "$folder/$name.part" 2> /dev/null < /dev/null && mv "$folder/$name.part" "$folder/$name.pgm" ||
    { rm -f "$folder/$name.part"; echo "photographs: cannot read $file" >&2; }
}
export folder
export -f take

awk '$1 == "trust" && $2 != "ffmpeg" { print $2 }' "$here/../../../toolchains/packages.txt" | while read -r package; do
  gather "$package"
done | tr '\t' '\n' | xargs -d '\n' -n 40 -P "$(nproc)" bash -c 'while (($# > 0)); do take "$1" "$2"; shift 2; done' take
echo "photographs: $(find "$folder" -mindepth 1 | wc -l) in $folder" >&2
