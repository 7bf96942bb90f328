# raysweep generate: volumes that can be read, the same for the same seed; no half files.
source "$(dirname "$0")/lib.sh" "$@"

for kind in cloud sphere box; do
    expect_exit 0 "$raysweep" generate $kind -o $kind.vdb --size 48
    expect_silent
    expect_exit 0 "$raysweep" info $kind.vdb --json
    cp .out $kind.json
    expect_json $kind.json "len(r['grids']) == 1 and r['grids'][0]['name'] == 'density'"
    expect_json $kind.json "abs(r['grids'][0]['transform']['voxel_size'][0] - 2 / 48) < 1e-12"
    expect_json $kind.json "r['grids'][0]['min'][0] > 0 and r['grids'][0]['max'][0] <= 1"
done
expect_json box.json "r['grids'][0]['active_voxels'] == 48 ** 3"

# One seed, one volume; another seed, another volume; --half is kept.
expect_exit 0 "$raysweep" generate cloud -o again.vdb --size 48 --threads 1
expect_exit 0 "$raysweep" compare again.vdb cloud.vdb --max-rms 0
expect_exit 0 "$raysweep" generate cloud -o other.vdb --size 48 --seed 2 --half
expect_exit 0 "$raysweep" info other.vdb
expect_output "saved as half"

expect_exit 0 "$raysweep" generate box -o dims.vdb --dims 30,20,10 --voxel-size 0.5 --density 2 --report report.json
expect_json report.json "r['voxels_active'] == 6000 and r['seconds'] >= 0"

# Phantoms for tomography: of --size, the box also of --dims; the largest density is --density.
expect_exit 0 "$raysweep" generate shepp-logan -o head.vdb --size 128 --density 2
expect_exit 0 "$raysweep" info head.vdb --json
cp .out head.json
expect_json head.json "r['grids'][0]['name'] == 'density' and abs(r['grids'][0]['max'][0] - 2) < 1e-6"
expect_exit 0 "$raysweep" generate box-with-holes -o holes.vdb --dims 48,40,24 --voxel-size 1 --report report.json
expect_json report.json "0.7 * 30 * 25 * 15 < r['voxels_active'] < 30 * 26 * 16"
expect_exit 2 "$raysweep" generate shepp-logan -o a.vdb --dims 48,40,24
expect_match "--dims"
if has_itk; then
    expect_exit 0 "$raysweep" generate shepp-logan -o head.vdb --size 32 --projections exact.mha --parallel --views 20 --detector 48,40,0.0625
    expect_exit 0 "$raysweep" ct exact.mha -o head_ct.vdb --parallel --reference head.vdb --report report.json
    expect_json report.json "r['rms_history'][-1] < 0.12"
else
    echo "skipped: exact projections, this build has no ITK"
fi
expect_exit 2 "$raysweep" generate cloud -o a.vdb --projections exact.mha --parallel --views 20 --detector 48,40,0.0625
expect_exit 2 "$raysweep" generate shepp-logan -o a.vdb --parallel
expect_match "--projections"

# Options from a file: flat keys belong to the subcommand that was called, the command line wins, other sections wait.
printf 'size = 20\n\n[info]\njson = true\n' >flat.toml
expect_exit 0 "$raysweep" generate box -o config.vdb --config flat.toml
expect_exit 2 "$raysweep" info config.vdb --config missing.toml
printf '[generate]\ndims = [4, 5, 6]\n' >section.toml
expect_exit 0 "$raysweep" generate box -o config.vdb --config section.toml --report report.json
expect_json report.json "r['voxels_active'] == 120"
expect_exit 0 "$raysweep" generate box -o config.vdb --config flat.toml --size 10 --report report.json
expect_json report.json "r['voxels_active'] == 1000"
printf 'output = "named.vdb"\nsize = 12\nquiet = true\n' >output.toml
expect_exit 0 "$raysweep" generate box --config output.toml
[ -f named.vdb ] || fail "a required option from a file was not used"
printf 'output = "-"\n' >output.toml
expect_exit 2 "$raysweep" generate box --config output.toml
printf 'sizze = 20\n' >wrong.toml
expect_exit 2 "$raysweep" generate box -o config.vdb --config wrong.toml
expect_match "sizze"

# Usage errors.
expect_exit 2 "$raysweep"
expect_exit 2 "$raysweep" genrate
expect_match "genrate"
expect_exit 2 "$raysweep" generate
expect_exit 2 "$raysweep" generate fog -o a.vdb
expect_exit 2 "$raysweep" generate box
expect_exit 2 "$raysweep" generate box -o -
expect_match "--output"
expect_exit 2 "$raysweep" generate box -o a.vdb --report -
expect_exit 2 "$raysweep" generate box -o a.vdb --size many
expect_exit 2 "$raysweep" generate box -o a.vdb --size 0
expect_exit 2 "$raysweep" generate box -o a.vdb --threads -1
expect_exit 2 "$raysweep" generate box -o a.vdb --dims 1,2
expect_match "for example --dims 64,32,16"
expect_exit 2 "$raysweep" generate box -o a.vdb --dims 1,2,x
expect_exit 2 "$raysweep" generate sphere -o a.vdb --dims 1,2,3
expect_exit 2 "$raysweep" generate sphere -o a.vdb --size 10 --soft 9
expect_exit 2 "$raysweep" generate sphere -o a.vdb --wrong
expect_match "--wrong"
[ ! -e a.vdb ] || fail "a usage error wrote a file"
expect_exit 0 "$raysweep" --version
expect_exit 0 "$raysweep" generate --help
expect_output "--voxel-size"

finish
