# raysweep slices: sections as a picture and as a page, which a browser shows; where they are, and what is refused.
source "$(dirname "$0")/lib.sh" "$@"

"$raysweep" generate shepp-logan --size 64 -o head.vdb
"$make_volume" turned-cloud turned.vdb
"$make_volume" materials colours.vdb
"$make_volume" sheared sheared.vdb
"$make_volume" stretched stretched.vdb  # 12 x 10 x 8 voxels of 0.1 x 0.2 x 0.05 units from 1, 2, 3 on, all 1

expect_exit 0 "$raysweep" slices head.vdb -o head.png --report report.json
expect_silent
expect_json report.json "r['grid'] == 'density' and r['window'] == r['range'] and all(abs(x) < 1 / 32 for x in r['at'])"
for input in turned sheared; do expect_exit 0 "$raysweep" slices $input.vdb -o $input.png; done
expect_exit 0 "$raysweep" slices stretched.vdb -o a.png --at 1.32,3.65,3.2 --window 0,2 --report report.json
expect_json report.json "r['voxel'] == [3, 8, 4] and r['window'] == [0, 2] and r['range'] == [1, 1]"
expect_json report.json "all(abs(a - b) < 1e-12 for a, b in zip(r['at'], (1.3, 3.6, 3.2)))"
expect_exit 0 "$raysweep" slices colours.vdb -o a.png --grid Cd --channel 2 --dense-box -1,0,0,11,9,7 --report report.json
expect_json report.json "r['dims'] == [13, 10, 8] and [round(x, 6) for x in r['range']] == [0, 0.3]"

# Every picture is one that can be read, and grey.
python3 - <<'PY' || fail "the pictures are not what they should be"
import struct, zlib
def pixels(name):
    data = open(name, "rb").read()
    width, height, depth, kind = struct.unpack(">IIBB", data[16:26])
    assert depth == 8 and kind == 2, (depth, kind)
    return width, height
for name in ("head.png", "turned.png", "sheared.png", "a.png"):
    width, height = pixels(name)
    assert 900 < width < 4400 and height > 100, (width, height)
PY

expect_exit 0 "$raysweep" slices head.vdb -o head.html --report report.json
expect_silent
for text in '<canvas' 'http:' 'https:' 'src=' 'href='; do
    grep -q "$text" head.html && fail "the page holds $text, so it needs something else"
done
expect_exit 0 "$raysweep" slices stretched.vdb -o stretched.html --at 1.32,3.65,3.2 --window 0,2
expect_exit 0 "$raysweep" slices turned.vdb -o turned.html

# In a browser: it unpacks the data and shows the value where the sections meet; the wheel goes through the slices, a press moves
# the others there.
browser=$(command -v chromium || command -v chromium-browser || command -v google-chrome)
dump() { timeout 120 "$browser" --headless --no-sandbox --disable-gpu --user-data-dir="$work/.browser" --virtual-time-budget=20000 --dump-dom "file://$work/$1" 2>/dev/null; }
if [ -n "$browser" ]; then
    dump stretched.html >dom.html
    grep -q 'data-ready="yes"' dom.html || fail "the page did not come up"
    grep -q 'voxel (3, 8, 4) at (1.3, 3.6, 3.2): 1.004 ± 0.0039' dom.html || fail "it shows another value or place: $(grep -o 'voxel ([^<]*' dom.html)"
    sed 's|</body>||; s|</html>||' stretched.html >driven.html
    cat >>driven.html <<'HTML'
<script>
const ready = setInterval(() => {
  if (document.body.dataset.ready !== "yes") return;
  clearInterval(ready);
  const frame = document.querySelector(".frame"), box = frame.getBoundingClientRect();
  frame.setPointerCapture = () => {};
  const at = { clientX: box.left + box.width * 0.04, clientY: box.top + box.height * 0.95, bubbles: true, buttons: 1 };
  frame.dispatchEvent(new WheelEvent("wheel", { ...at, deltaY: -120, cancelable: true }));
  frame.dispatchEvent(new PointerEvent("pointerdown", at));
  document.body.dataset.driven = document.getElementById("readout").textContent;
}, 50);
</script></body></html>
HTML
    dump driven.html | grep -o 'data-driven="[^"]*"' >driven.txt
    grep -q 'voxel (0, 0, 5) at (1, 2, 3.25)' driven.txt || fail "wheel and press led to $(cat driven.txt)"
    for page in head turned; do
        dump $page.html >dom.html
        grep -q 'data-ready="yes"' dom.html || fail "$page.html did not come up"
    done
else
    echo "skipped: pages in a browser; there is no Chromium"
fi

# What is refused.
echo "the old file" >old.png
before=$(cksum old.png)
refused() {  # CODE TEXT OPTIONS...
    local code=$1 text=$2
    shift 2
    expect_exit "$code" "$raysweep" slices "$@"
    expect_match "$text"
}
refused 2 "must end in .png or .html" head.vdb -o a.exr
refused 2 "--window 2,1: must be two numbers, the lower one first" head.vdb -o old.png --window 2,1
refused 2 "--window" head.vdb -o old.png --window 2
refused 2 "--at" head.vdb -o old.png --at 1,2
refused 2 "'head.vdb' must end" head.vdb -o head.vdb
refused 1 "--at: 9, 0, 0 must be within the volume" head.vdb -o old.png --at 9,0,0
refused 1 "choose one by --channel" colours.vdb -o old.png --grid Cd
refused 1 "there is no grid called" head.vdb -o old.png --grid x
"$make_volume" nan nan.vdb
refused 1 "NaN or infinite at voxel (3, 4, 5)" nan.vdb -o old.png
refused 1 "NaN or infinite" nan.vdb -o old.html
refused 1 "have room for 2^30; choose a smaller part by --dense-box" stretched.vdb -o old.html --dense-box 0,0,0,2000,1000,999
"$make_volume" frustum frustum.vdb
refused 1 "density" frustum.vdb -o old.png
[ "$(cksum old.png)" = "$before" ] && [ ! -e old.html ] || fail "an old file was harmed, or a new one left"
expect_no_leftovers .

finish
