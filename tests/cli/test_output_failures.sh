# Writing fails cleanly: a message, exit 1, no half file, and what was there before is still there.
source "$(dirname "$0")/lib.sh" "$@"

expect_exit 1 "$raysweep" generate box -o missing/a.vdb --size 8
expect_match "missing"
expect_match "does not exist"
touch file
expect_exit 1 "$raysweep" generate box -o file/a.vdb --size 8
mkdir folder
expect_exit 1 "$raysweep" generate box -o folder --size 8
expect_match "folder"
expect_exit 1 "$raysweep" generate box -o a.vdb --size 8 --report missing/report.json
expect_match "report.json"

# Root may write anywhere, so it becomes nobody for this.
mkdir readonly && chmod a=rx readonly
as_user=()
[ "$(id -u)" = 0 ] && as_user=(setpriv --reuid=65534 --regid=65534 --clear-groups)
if "${as_user[@]}" "$raysweep" --version >/dev/null 2>&1; then
    expect_exit 1 "${as_user[@]}" "$raysweep" generate box -o "$work/readonly/a.vdb" --size 8
    expect_match "permission"
else
    echo "skipped: read-only folder, root may write anywhere and cannot become somebody else here"
fi

# A file that cannot grow: a limit on its size stands for a full disk, and needs no privileges.
mkdir limited && "$raysweep" generate box -o limited/old.vdb --size 4
before=$(cksum limited/old.vdb)
expect_exit 1 bash -c "ulimit -f 16; exec '$raysweep' generate cloud -o limited/old.vdb --size 64"
expect_match "cannot write 'limited/old.vdb'"
[ "$(cksum limited/old.vdb)" = "$before" ] || fail "the old file was harmed"
expect_no_leftovers limited

# A disk that is really full, where one can be had.
mkdir full
if mount -t tmpfs -o size=64k tmpfs full 2>/dev/null; then
    trap 'umount "$work/full"' EXIT
    expect_exit 1 "$raysweep" generate cloud -o full/a.vdb --size 64
    expect_match "No space left"
    expect_no_leftovers full
    [ ! -e full/a.vdb ] || fail "a partial file appeared"
else
    echo "skipped: full disk, no permission to mount one"
fi
if [ -w /dev/full ]; then
    expect_exit 1 bash -c "'$raysweep' info limited/old.vdb >/dev/full"
    expect_match "standard output"
fi

finish
