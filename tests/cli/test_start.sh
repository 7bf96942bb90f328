# What takes long to load is loaded when it is needed: not to say what is in a volume, nor to write an EXR.
source "$(dirname "$0")/lib.sh" "$@"

"$raysweep" generate sphere --size 16 -o a.vdb --quiet || exit 1
"$raysweep" light a.vdb -o lit.vdb --extinction 1 --sun 0,0,-1,1 --quiet || exit 1
# loads MODULE COMMAND...: the dynamic linker tells which files it opens.
loads() {
    local module=$1
    shift
    LD_DEBUG=files "$@" >/dev/null 2>"$work/.files" || fail "exit $?: $*"
    grep -q "$module" "$work/.files"
}

loads libz "$raysweep" info a.vdb || { echo "skipped: the linker does not tell what it loads"; exit 77; }
for library in OpenImageIO ITKCommon dcmdata raysweep_pictures raysweep_medical; do
    loads "$library" "$raysweep" info a.vdb && fail "info loads $library"
done
loads OpenImageIO "$raysweep" render lit.vdb -o a.exr --size 8,8 --quiet && fail "an EXR needs OpenImageIO"
loads OpenImageIO "$raysweep" compare a.exr a.exr && fail "reading an EXR needs OpenImageIO"
loads OpenImageIO "$raysweep" render lit.vdb -o a.png --size 8,8 --quiet || fail "who writes PNG?"
[ -s a.png ] || fail "no PNG was written"

# A module that cannot be loaded is named, and nothing is left behind. (One beside the program comes first.)
mkdir moved && cp "$raysweep" moved/ && echo "no library" >moved/raysweep_pictures.so || exit 1
cp moved/raysweep_pictures.so moved/raysweep_medical.so
expect_exit 1 moved/raysweep render lit.vdb -o b.png --size 8,8
expect_match "cannot write 'b.png': only EXR pictures can be used: '$work/moved/raysweep_pictures.so' could not be loaded"
expect_no_leftovers .
expect_exit 1 moved/raysweep compare a.png a.exr
expect_match "cannot read 'a.png': only EXR pictures can be used"
echo nothing >a.dcm
expect_exit 1 moved/raysweep import a.dcm -o b.vdb
expect_match "this build of Raysweep has no ITK"
expect_exit 0 moved/raysweep render lit.vdb -o b.exr --size 8,8

finish
