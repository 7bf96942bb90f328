# The README, as a newcomer types it: its lines of shell and its C++, one after the other in one folder. Only the engine room is
# lit on voxels four times as long: as it stands, it takes a minute.
source "$(dirname "$0")/lib.sh" "$@"
need_itk

readme=$(dirname "${BASH_SOURCE[0]}")/../../README.md
PATH=$(dirname "$raysweep"):$PATH
# What it takes for granted.
raysweep generate cloud -o smoke.vdb --size 48
raysweep generate shepp-logan -o head.vdb --size 128

lines=0
while IFS= read -r line; do
    expect_exit 0 bash -c "${line/--quality final/--quality final --resolution 0.25}"
    lines=$((lines + 1))
done < <(sed -n 's/^    \(raysweep\(-cube4\)\? .*\)/\1/p' "$readme")
[ "$lines" -ge 13 ] || fail "only $lines lines found"
for file in lit.vdb lit.png room.vdb scan.mha volume.vdb slices.png; do
    [ -s "$file" ] || fail "$file was not written"
done

expect_exit 0 "$(dirname "$raysweep")/raysweep_readme"

finish
