# raysweep photo, end to end: volumes come back from their photographs, by every method and from every kind of matting;
# what is in the report; what cannot be used is refused with a message and leaves outputs as they were.
source "$(dirname "$0")/lib.sh" "$@"

# A small translucent thing, photographed from all around: with alpha, before white and black, and from elsewhere.
"$raysweep" generate triangles -o tri.vdb --size 24 --count 12
shoot() { expect_exit 0 "$raysweep" shoot tri.vdb -o "$@" --size 48,48 --quiet; }
shoot views --views 12 --orbit sphere
shoot pairs --views 12 --orbit sphere --backdrop white,black
shoot others --views 3 --arc 300
shoot parallel --views 12 --ortho auto

small=(--size 24 --bounds=-1,-1,-1,1,1,1)
photo() { expect_exit 0 "$raysweep" photo "$@" --report report.json; }

# Every method; what the report says. PSNR is at most 10 % of an error's size below what is found, unless said otherwise.
by() {  # METHOD PSNR-OF-USED PSNR-OF-HELD-OUT OPTIONS...
    local method=$1 used=$2 held=$3
    shift 3
    photo views -o $method.vdb "${small[@]}" --method $method --hold-out 4 "$@"
    expect_silent
    expect_json report.json "r['method'] == '$method' and r['termination'] == 'iterations' and r['matting'] == 'alpha'"
    expect_json report.json "r['psnr_train'] > $used and r['psnr_held_out'] > $held and 0.5 < r['ssim_held_out'] < 1"
    expect_json report.json "r['views'] == 9 and r['views_held_out'] == 3 and len(r['view_list']) == 12"
    for key in seconds peak_bytes updates image_error_history voxels_active bounds timings warnings resolution; do
        expect_json report.json "'$key' in r"
    done
    echo $method: $(json report.json "r['psnr_train'], r['psnr_held_out'], r['ssim_held_out'], r['seconds']")
}
by fit 0 0
by consistent 0 0
by paper 0 0
