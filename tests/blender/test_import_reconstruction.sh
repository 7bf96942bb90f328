# examples/blender/import_reconstruction.py: Cycles shows volumes with colours as raysweep render does, and lights them anew
# as raysweep light does.
here=$(cd "$(dirname "$0")" && pwd)
source "$here/../cli/lib.sh" "$@"
script=$here/../../examples/blender/import_reconstruction.py

if ! command -v blender >/dev/null; then
    echo "skipped: blender is not here (scripts/setup.sh --tests installs it)"
    exit 77
fi

# Blender ends with 0 whatever becomes of a script, unless told otherwise.
run() { expect_exit "$1" blender -b --python-exit-code 3 -P "$script" -- "${@:2}"; }
in_blender() { run 0 "$@" --raysweep "$raysweep" --samples 32; }

# Photographs' volumes have the same grids as these triangles.
"$raysweep" generate triangles -o tri.vdb --size 48 --count 60

in_blender tri.vdb shown.exr --size 96,96
expect_exit 0 "$raysweep" render tri.vdb -o reference.exr --size 96,96 --samples 3 --step 0.25
expect_exit 0 "$raysweep" compare shown.exr reference.exr --max-rms 0.0013  # found: 0.0012, the noise of 32 samples

in_blender tri.vdb relit.png --size 128,128 --relight --background 0.4 --sun 0.3,1,-0.8,3
expect_exit 0 "$raysweep" light tri.vdb -o lit.vdb --albedo grid:Cd --sky 0.4 --sun 0.3,1,-0.8,3 --tolerance 0.02
expect_exit 0 "$raysweep" render lit.vdb -o lit.png --size 128,128 --background 0.4
expect_exit 0 "$raysweep" compare relit.png lit.png --max-rms 0.0095  # found: 0.0087, most of it noise

"$raysweep" generate sphere -o sphere.vdb --size 16
run 1 sphere.vdb no.png --raysweep "$raysweep"
expect_match "has no grid 'Cd': it is no volume of raysweep photo"
run 1 missing.vdb no.png
expect_match "there is no file 'missing.vdb'"
run 2 tri.vdb no.png --sun 0,0,0,1
expect_match "--sun"
run 2 tri.vdb no.png --bounces -1
expect_match "--bounces"
[ -z "$(ls no.* 2>/dev/null)" ] || fail "left behind: $(ls no.*)"
expect_no_leftovers .

finish
