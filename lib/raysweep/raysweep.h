/// Raysweep: light transport and reconstruction in sparse volumes.
///
/// One call lights a volume: illuminate(scene, options), with the scene of sceneFrom(file, options); writeLit keeps the
/// result, render(litVolume(file), camera) shows it. To see how it works, read in this order: sweep/ray_front.h (a
/// front of rays), sweep/exchange.h (what rays and voxels exchange), sweep/wavefront.h (in which order),
/// illuminate/illuminate.h (what is iterated), illuminate/coarse_level.h (where it begins).
///
/// Two calls make a volume of X-rays: readScan(options), files to line integrals and where their rays ran, and
/// reconstruct(scan, options). In this order: scan/scan.h, camera/projection_geometry.h (where rays run),
/// projector/joseph.h (what they meet), projector/project.h and projector/backproject.h (both ways), reconstruct/sart.h
/// and reconstruct/fbp.h (the methods), reconstruct/reconstruct.h.
///
/// Two calls make a volume of photographs: readPhotographSets(input, options), files to mattes and cameras, and
/// reconstructPhotographs(photographs, options); judge(volume, photographs) says how well it shows them.
///
/// Quantities and units: docs/units.md.
#pragma once

#include "raysweep/camera/camera.h"
#include "raysweep/camera/object_bounds.h"
#include "raysweep/camera/photograph_sets.h"
#include "raysweep/camera/pose_check.h"
#include "raysweep/camera/poses.h"
#include "raysweep/camera/projection_geometry.h"
#include "raysweep/camera/projections.h"
#include "raysweep/formats/dense_files.h"
#include "raysweep/formats/sections.h"
#include "raysweep/formats/volume_import.h"
#include "raysweep/illuminate/illuminate.h"
#include "raysweep/illuminate/illumination_record.h"
#include "raysweep/image/compare.h"
#include "raysweep/image/image_io.h"
#include "raysweep/image/matte_picture.h"
#include "raysweep/image/matting.h"
#include "raysweep/mesh/mesh_files.h"
#include "raysweep/mesh/mesh_volume.h"
#include "raysweep/phantoms/ct_phantoms.h"
#include "raysweep/phantoms/engine_room.h"
#include "raysweep/phantoms/exact_projections.h"
#include "raysweep/phantoms/explosion.h"
#include "raysweep/phantoms/phantom.h"
#include "raysweep/phantoms/triangles.h"
#include "raysweep/projector/project_grid.h"
#include "raysweep/reconstruct/fbp.h"
#include "raysweep/reconstruct/photo.h"
#include "raysweep/reconstruct/photo_confidence.h"
#include "raysweep/reconstruct/reconstruct.h"
#include "raysweep/reconstruct/sart.h"
#include "raysweep/reconstruct/sart_record.h"
#include "raysweep/render/bake.h"
#include "raysweep/render/lit_volume.h"
#include "raysweep/render/photo_quality.h"
#include "raysweep/render/render.h"
#include "raysweep/render/rig.h"
#include "raysweep/render/shading.h"
#include "raysweep/scan/data_exchange.h"
#include "raysweep/scan/detector.h"
#include "raysweep/scan/geometry_io.h"
#include "raysweep/scan/line_integrals.h"
#include "raysweep/scan/projection_io.h"
#include "raysweep/scan/ring_filter.h"
#include "raysweep/scan/rotation_center.h"
#include "raysweep/scan/scan.h"
#include "raysweep/scan/scan_geometry.h"
#include "raysweep/scene/lit_file.h"
#include "raysweep/scene/scene.h"
#include "raysweep/scene/scene_io.h"
#include "raysweep/scene/sky_map.h"
#include "raysweep/volume/checksum.h"
#include "raysweep/volume/classify.h"
#include "raysweep/volume/color_volume.h"
#include "raysweep/volume/cycles_export.h"
#include "raysweep/volume/grid_select.h"
#include "raysweep/volume/middle_slices.h"
#include "raysweep/volume/resample.h"
#include "raysweep/volume/similarity.h"
#include "raysweep/volume/solid.h"
#include "raysweep/volume/vdb_io.h"
#include "raysweep/volume/voxel_check.h"
