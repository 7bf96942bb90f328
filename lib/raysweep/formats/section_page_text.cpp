// Written for browsers of 2023 and later (DecompressionStream). All of it is one file: no network, no storage.
#include "raysweep/formats/section_page.h"

namespace raysweep {

const char* const kPageBeforeData = R"html(<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Raysweep: sections</title>
<style>
  :root { color-scheme: dark; --x: #ff6b5e; --y: #7ad151; --z: #5aa9ff; }
  body { margin: 0; padding: 12px 16px; background: #1b1b1d; color: #dcdcdc; font: 14px/1.45 system-ui, sans-serif; }
  h1 { font-size: 16px; font-weight: 600; margin: 0; }
  h1 small { font-weight: 400; color: #a0a0a4; margin-left: 8px; }
  #views { display: flex; gap: 22px; align-items: flex-end; margin: 10px 0 6px; }
  .view h2 { font-size: 13px; font-weight: 400; margin: 0 0 3px; white-space: nowrap; }
  .frame { position: relative; outline: 1px solid; cursor: crosshair; touch-action: none; overflow: hidden; background: #000; }
  .frame canvas { display: block; width: 100%; height: 100%; }
  .line { position: absolute; pointer-events: none; opacity: .75; }
  .line.up { top: 0; bottom: 0; width: 1px; }
  .line.across { left: 0; right: 0; height: 1px; }
  .axis { position: absolute; color: #fff; opacity: .8; font-size: 12px; pointer-events: none; text-shadow: 0 0 3px #000, 0 0 3px #000; }
  .view input { width: 100%; min-width: 90px; margin: 6px 0 0; box-sizing: border-box; }
  #readout { font-variant-numeric: tabular-nums; min-height: 1.5em; margin: 6px 0; }
  .row { display: flex; flex-wrap: wrap; gap: 6px 26px; align-items: center; }
  .row label { display: flex; gap: 8px; align-items: center; }
  .row output { min-width: 5em; font-variant-numeric: tabular-nums; }
  #scale { height: 10px; border: solid #dcdcdc; border-width: 0 1px 2px; box-sizing: border-box; }
  #ramp { width: 120px; height: 14px; background: linear-gradient(to right, #000, #fff); }
  button { font: inherit; }
  .help { color: #a0a0a4; font-size: 13px; margin: 8px 0 0; }
</style>
</head>
<body>
<h1><span id="name"></span><small id="size"></small></h1>
<div id="views"></div>
<p id="readout">This page needs JavaScript.</p>
<div class="row">
  <div class="row"><div id="scale"></div><span id="length"></span></div>
  <label>black <input type="range" id="low" min="0" max="1000"><output id="lowValue"></output></label>
  <div id="ramp"></div>
  <label>white <input type="range" id="high" min="0" max="1000"><output id="highValue"></output></label>
  <button id="reset">whole range</button>
</div>
<p class="help">Wheel: through the slices. Press or drag: move all three sections there. Hover: the value under the pointer.</p>
)html";

const char* const kPageAfterData = R"html(<script>
"use strict";
const about = JSON.parse(document.getElementById("about").textContent);
const dims = about.dims, strides = [1, dims[0], dims[0] * dims[1]];
const voxels = new Uint8Array(strides[2] * dims[2]);
const [codedLow, codedHigh] = about.coded;
const at = about.at.slice();
const colours = ["x", "y", "z"].map(axis => `var(--${axis})`);
const ends = [0, 1000];  // of the window, in thousandths of what is coded
const byId = id => document.getElementById(id);
const brief = (number, digits = 4) => String(Number(number.toPrecision(digits)));
const element = (parent, tag, name = "") => {
  const made = document.createElement(tag);
  made.className = name;
  parent.append(made);
  return made;
};

// ---- The data: slabs of slices, zlib, base64.
async function unpacked(text) {
  const packed = atob(text), bytes = new Uint8Array(packed.length);
  for (let n = 0; n < packed.length; ++n) bytes[n] = packed.charCodeAt(n);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

async function load() {
  const slabs = [...document.querySelectorAll("script.slab")];
  let end = 0;
  for (const [n, slab] of slabs.entries()) {
    byId("readout").textContent = `unpacking, ${n + 1} of ${slabs.length}`;
    const part = await unpacked(slab.textContent);
    voxels.set(part, end);
    end += part.length;
    slab.remove();
  }
  if (end !== voxels.length) throw new Error("the file is damaged: voxels are missing");
}

// ---- What voxels are.
const indexOf = voxel => voxel[0] + voxel[1] * strides[1] + voxel[2] * strides[2];
const placeOf = voxel => about.origin.map((origin, n) =>
  origin + voxel[0] * about.steps[0][n] + voxel[1] * about.steps[1][n] + voxel[2] * about.steps[2][n]);

function valueOf(voxel) {
  const code = voxels[indexOf(voxel)], error = (codedHigh - codedLow) / 510;
  if (code === 0 && about.range[0] < codedLow) return `at most ${brief(codedLow + error)}`;
  if (code === 255 && about.range[1] > codedHigh) return `at least ${brief(codedHigh - error)}`;
  const value = codedLow + code / 255 * (codedHigh - codedLow);
  return error > 0 ? `${brief(value)} ± ${brief(error, 2)}` : brief(value);
}

function show(voxel) {
  const index = voxel.map((n, axis) => n + about.corner[axis]).join(", ");
  byId("readout").textContent =
    `voxel (${index}) at (${placeOf(voxel).map(n => brief(n, 6)).join(", ")}): ${valueOf(voxel)}`;
}

// ---- Sections: across axis `normal`, `right` to the right, `up` upwards.
class View {
  constructor(normal, right, up) {
    Object.assign(this, { normal, right, up, wheel: 0 });
    const box = element(byId("views"), "div", "view");
    this.title = element(box, "h2");
    this.frame = element(box, "div", "frame");
    this.frame.style.outlineColor = colours[normal];
    this.canvas = element(this.frame, "canvas");
    this.canvas.width = dims[right];
    this.canvas.height = dims[up];
    this.context = this.canvas.getContext("2d");
    this.pixels = this.context.createImageData(dims[right], dims[up]);
    this.upLine = element(this.frame, "div", "line up");
    this.acrossLine = element(this.frame, "div", "line across");
    this.upLine.style.background = colours[right];
    this.acrossLine.style.background = colours[up];
    const upName = element(this.frame, "span", "axis"), rightName = element(this.frame, "span", "axis");
    upName.textContent = about.axes[up] + " ↑";
    upName.style.cssText = "left:4px;top:1px";
    rightName.textContent = about.axes[right] + " →";
    rightName.style.cssText = "right:4px;bottom:1px";
    this.slider = element(box, "input");
    Object.assign(this.slider, { type: "range", min: 0, max: dims[normal] - 1, value: at[normal] });
    this.slider.setAttribute("aria-label", "slice along " + about.axes[normal]);
    this.slider.addEventListener("input", () => move(normal, Number(this.slider.value)));
    this.listen();
  }

  listen() {
    this.frame.addEventListener("wheel", event => {
      event.preventDefault();
      this.wheel += event.deltaMode === 0 ? event.deltaY : 100 * event.deltaY;
      const wanted = Math.abs(event.deltaY) >= 100 || event.deltaMode !== 0 ? 1 : 40;  // a notch, or a touchpad
      if (Math.abs(this.wheel) < wanted) return;
      move(this.normal, at[this.normal] - Math.sign(this.wheel));
      this.wheel = 0;
      show(this.voxelUnder(event));
    }, { passive: false });
    const press = event => {
      const voxel = this.voxelUnder(event);
      for (const axis of [this.right, this.up]) at[axis] = voxel[axis];
      drawAll();
    };
    this.frame.addEventListener("pointerdown", event => {
      this.frame.setPointerCapture(event.pointerId);
      press(event);
    });
    this.frame.addEventListener("pointermove", event => {
      if (event.buttons & 1) press(event);
      show(this.voxelUnder(event));
    });
    this.frame.addEventListener("pointerleave", () => show(at));
  }

  voxelUnder(event) {
    const box = this.frame.getBoundingClientRect(), voxel = at.slice();
    const along = (part, axis) => Math.min(dims[axis] - 1, Math.max(0, Math.floor(part * dims[axis])));
    voxel[this.right] = along((event.clientX - box.left) / box.width, this.right);
    voxel[this.up] = along(1 - (event.clientY - box.top) / box.height, this.up);
    return voxel;
  }

  resize(pixelsPerUnit) {
    this.frame.style.width = dims[this.right] * about.spacing[this.right] * pixelsPerUnit + "px";
    this.frame.style.height = dims[this.up] * about.spacing[this.up] * pixelsPerUnit + "px";
    const pixels = pixelsPerUnit * Math.min(about.spacing[this.right], about.spacing[this.up]);
    this.canvas.style.imageRendering = pixels < 2 ? "auto" : "pixelated";  // small ones would differ in width
  }

  draw() {
    const width = dims[this.right], height = dims[this.up];
    const out = new Uint32Array(this.pixels.data.buffer), step = strides[this.right];
    for (let y = 0, n = 0; y < height; ++y) {
      let from = at[this.normal] * strides[this.normal] + (height - 1 - y) * strides[this.up];
      for (let x = 0; x < width; ++x, from += step) out[n++] = greys[voxels[from]];
    }
    this.context.putImageData(this.pixels, 0, 0);
    this.upLine.style.left = `calc(${100 * (at[this.right] + 0.5) / width}% - 0.5px)`;
    this.acrossLine.style.bottom = `calc(${100 * (at[this.up] + 0.5) / height}% - 0.5px)`;
    this.slider.value = at[this.normal];
    this.title.textContent = this.heading();
  }

  heading() {
    const name = about.axes[this.normal], world = "xyz".indexOf(name.slice(-1));
    if (world < 0) return `${name} = ${at[this.normal] + about.corner[this.normal]}`;
    return `${name.slice(-1)} = ${brief(placeOf(at)[world], 6)}`;
  }
}

// ---- The window.
const greys = new Uint32Array(256);
const thousandth = n => codedLow + n / 1000 * (codedHigh - codedLow);

function setWindow() {
  for (let code = 0; code < 256; ++code) {
    const part = (code / 255 * 1000 - ends[0]) / Math.max(1, ends[1] - ends[0]);
    const grey = Math.round(255 * Math.min(1, Math.max(0, part)));
    greys[code] = (0xff000000 | grey << 16 | grey << 8 | grey) >>> 0;
  }
  byId("low").value = ends[0];
  byId("high").value = ends[1];
  byId("lowValue").textContent = brief(thousandth(ends[0]));
  byId("highValue").textContent = brief(thousandth(ends[1]));
}

// ---- The page.
const views = [[2, 0, 1], [1, 0, 2], [0, 1, 2]].map(axes => new View(...axes));

function drawAll() {
  for (const view of views) view.draw();
  show(at);
}

function move(axis, to) {
  at[axis] = Math.min(dims[axis] - 1, Math.max(0, to));
  drawAll();
}

function resize() {
  const gaps = 22 * (views.length - 1) + 32 + 6, below = 250;
  let width = 0, height = 0;
  for (const view of views) {
    width += dims[view.right] * about.spacing[view.right];
    height = Math.max(height, dims[view.up] * about.spacing[view.up]);
  }
  const pixelsPerUnit = Math.min(Math.max(300, innerWidth - gaps) / width, Math.max(150, innerHeight - below) / height);
  for (const view of views) view.resize(pixelsPerUnit);
  const longest = 160 / pixelsPerUnit, power = 10 ** Math.floor(Math.log10(longest));
  const length = [5, 2, 1].map(factor => factor * power).find(candidate => candidate <= longest);
  byId("scale").style.width = length * pixelsPerUnit + "px";
  byId("length").textContent = brief(length) + (length === 1 ? " unit" : " units");
}

for (const [n, id] of ["low", "high"].entries())
  byId(id).addEventListener("input", event => {
    ends[n] = Number(event.target.value);
    ends[1 - n] = n === 0 ? Math.max(ends[1], ends[0]) : Math.min(ends[0], ends[1]);
    setWindow();
    drawAll();
  });
byId("reset").addEventListener("click", () => {
  ends[0] = 0, ends[1] = 1000;
  setWindow();
  drawAll();
});
addEventListener("resize", resize);

byId("name").textContent = about.name || "(no name)";
byId("size").textContent = `${dims.join(" × ")} voxels of ${about.spacing.map(n => brief(n)).join(" × ")} units` +
  (about.sheared ? "; axes are sheared, which is not shown" : "");
document.title = `${about.name || "volume"}: sections`;
resize();
setWindow();
load().then(() => {
  drawAll();
  document.body.dataset.ready = "yes";
}).catch(error => {
  byId("readout").textContent = typeof DecompressionStream === "undefined"
    ? "This browser cannot unpack the data (DecompressionStream): take one of 2023 or later." : String(error);
});
</script>
</body>
</html>
)html";

}  // namespace raysweep
