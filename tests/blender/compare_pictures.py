"""blender -b -P compare_pictures.py -- REPORT.json NAME...: for each NAME, how far NAME.blender.exr is from
NAME.raysweep.exr. Run in Blender because it reads EXR and has numpy, which the system's Python may lack."""

import json
import sys

import bpy
import numpy

SILHOUETTE = 0.01  # least opacity, or part of the brightest pixel: fainter ones are nearly all noise


def load(path):
    """Height x width x RGBA, row 0 at the bottom."""
    image = bpy.data.images.load(path)
    image.colorspace_settings.name = "Non-Color"  # the values as stored
    values = numpy.empty(image.size[0] * image.size[1] * 4, numpy.float32)
    image.pixels.foreach_get(values)
    return values.reshape(image.size[1], image.size[0], 4).astype(float)


def middle(picture):
    """Mean RGBA of the 6 x 6 pixels in the middle."""
    y, x = picture.shape[0] // 2, picture.shape[1] // 2
    return picture[y - 3:y + 3, x - 3:x + 3].mean(axis=(0, 1)).tolist()


def compare(ours, reference):
    brightness = reference[..., :3].max(axis=2)
    inside = (reference[..., 3] > SILHOUETTE) | (brightness > SILHOUETTE * brightness.max())
    a, b = ours[inside][:, :3], reference[inside][:, :3]
    return {
        "pixels": int(inside.sum()),
        "relative": float((abs(a - b).sum(axis=1) / b.sum(axis=1)).mean()),  # mean over pixels
        "bias": float((a - b).sum() / b.sum()),
        "opacity": float(abs(ours - reference)[inside][:, 3].mean()),
        "middle": middle(ours),
    }


report, *names = sys.argv[sys.argv.index("--") + 1:]
result = {name: compare(load(f"{name}.blender.exr"), load(f"{name}.raysweep.exr")) for name in names}
with open(report, "w") as out:
    json.dump(result, out, indent=2)
for name, figures in result.items():
    print(f"{name:16} {figures['pixels']:5} pixels, relative difference {100 * figures['relative']:.2f} %, "
          f"bias {100 * figures['bias']:+.3f} %, opacity {figures['opacity']:.5f}")
