#include "photo_report.h"
#include "plot.h"

#include "raysweep/volume/active_values.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace raysweep::apps {
namespace {

using Json = nlohmann::ordered_json;

Json listOf(const Vec3& v) {
    return {v.x, v.y, v.z};
}

/// What is not known is null.
template <class Value>
Json historyOf(const PhotoReconstruction& result, Value PhotoPoint::*value) {
    Json json = Json::array();
    for (const PhotoPoint& point : result.history)
        json.push_back(std::isfinite(double(point.*value)) ? Json(point.*value) : Json(nullptr));
    return json;
}

Json describe(const MatteReport& matte) {
    Json json = {{"pixels", matte.pixels},         {"covered", matte.covered},           {"opaque", matte.opaque},
                 {"coverage", matte.coverage},     {"inconsistent", matte.inconsistent}, {"holes", matte.holes},
                 {"hole_pixels", matte.holePixels}};
    if (matte.misregistration) json["misregistration"] = {matte.misregistration->x, matte.misregistration->y};
    return json;
}

/// Views that were not judged, as it was stopped, have no figures.
void addViews(Json& views, const PhotographSet& set, const PhotoQuality& quality, const char* name,
              const std::vector<RefinedPose>& poses = {}) {
    for (std::size_t n = 0; n < set.views.size(); ++n) {
        Json view = {{"name", set.views[n].name},
                     {"set", name},
                     {"width", set.views[n].camera.width},
                     {"height", set.views[n].camera.height}};
        if (n < quality.views.size()) {
            view["psnr"] = finiteOrNull(quality.views[n].psnr);
            view["ssim"] = quality.views[n].ssim;
            view["residual"] = quality.views[n].residual;
        }
        if (n < poses.size()) view["pose"] = {{"turned_degrees", poses[n].turn}, {"moved_pixels", poses[n].motion}};
        view["matte"] = describe(set.mattes[n]);
        views.push_back(view);
    }
}

/// Mean over the views of both that no reconstruction has seen; null if there are none.
Json meanOf(const Judgement& judgement, double PhotoQuality::*value) {
    const PhotoQuality &held = judgement.heldOut, &test = judgement.test;
    const double count = double(held.views.size() + test.views.size());
    if (count == 0) return nullptr;
    double sum = 0;
    for (const PhotoQuality* set : {&held, &test})
        if (!set->views.empty()) sum += set->*value * double(set->views.size());
    return finiteOrNull(sum / count);
}

Json valueOf(const PhotoQuality& quality, double PhotoQuality::*value) {
    return quality.views.empty() ? Json(nullptr) : finiteOrNull(quality.*value);
}

void addQuality(Json& json, const Judgement& judgement) {
    json["psnr_train"] = valueOf(judgement.used, &PhotoQuality::psnr);
    json["ssim_train"] = valueOf(judgement.used, &PhotoQuality::ssim);
    json["psnr_held_out"] = meanOf(judgement, &PhotoQuality::psnr);
    json["ssim_held_out"] = meanOf(judgement, &PhotoQuality::ssim);
    if (!judgement.directional.views.empty()) {
        json["psnr_held_out_directional"] = judgement.directional.psnr;
        json["ssim_held_out_directional"] = judgement.directional.ssim;
    }
    json["views_standing_out"] = Json::array();
    for (const std::size_t n : judgement.standingOut)
        json["views_standing_out"].push_back(judgement.used.views[n].name);
}

void addHistory(Json& json, const PhotoReconstruction& result, bool compared) {
    json["updates"] = result.updates;
    json["updates_history"] = historyOf(result, &PhotoPoint::updates);
    json["seconds_history"] = historyOf(result, &PhotoPoint::seconds);
    json["resolution_history"] = historyOf(result, &PhotoPoint::resolution);
    json["image_error_history"] = historyOf(result, &PhotoPoint::imageError);
    json["left_out_error_history"] = historyOf(result, &PhotoPoint::leftOut);
    if (!compared) return;
    json["rms_opacity_history"] = historyOf(result, &PhotoPoint::opacity);
    json["rms_color_history"] = historyOf(result, &PhotoPoint::color);
}

/// Voxels that a photograph sees.
std::size_t countOf(const openvdb::FloatGrid& views) {
    return sumOverActive<std::size_t>(views, [](std::size_t& count, float seen, const openvdb::CoordBBox& box) {
        if (seen > 0) count += std::size_t(box.volume());
    });
}

void addLight(Json& json, const PhotoReconstruction& result) {
    if (!result.light) return;
    const PhotoLight& light = *result.light;
    json["light"] = {{"direction", listOf(light.shading.light)},
                     {"ambient", light.shading.ambient},
                     {"diffuse", light.shading.diffuse},
                     {"residual", light.residual},
                     {"residual_aside", light.aside},
                     {"residual_ambient", light.ambient},
                     {"confidence", light.confidence}};
}

const char* nameOf(MattingOptions::Matting matting) {
    using Matting = MattingOptions::Matting;
    switch (matting) {
        case Matting::alpha:
            return "alpha";
        case Matting::whiteBlack:
            return "white-black";
        case Matting::black:
            return "black";
        case Matting::white:
            return "white";
        case Matting::known:
            return "known";
        default:
            return "masks";
    }
}

const char* nameOf(PhotoTermination termination) {
    switch (termination) {
        case PhotoTermination::interrupted:
            return "interrupted";
        case PhotoTermination::overfitted:
            return "overfitted";
        case PhotoTermination::noRoom:
            return "no-room";
        default:
            return "iterations";
    }
}

}  // namespace

nlohmann::ordered_json describe(const PhotoArguments& a, const PhotoOutcome& outcome) {
    const PhotoReconstruction& result = outcome.result;
    const PhotographSets& sets = outcome.sets;
    const Box3 bounds = worldBounds(*result.density);
    Json views = Json::array();
    addViews(views, sets.used, outcome.judgement.used, "train", result.poses);
    addViews(views, sets.heldOut, outcome.judgement.heldOut, "held-out");
    addViews(views, sets.test, outcome.judgement.test, "test");
    Json json = {{"method", a.method},
                 {"matting", nameOf(sets.matting)},
                 {"seconds", outcome.seconds},
                 {"peak_bytes", outcome.peakBytes},
                 {"termination", nameOf(result.termination)}};
    addQuality(json, outcome.judgement);
    if (a.method == "fit") json["smoothness"] = result.smoothness;
    json["views"] = sets.used.views.size();
    json["views_held_out"] = sets.heldOut.views.size();
    json["views_test"] = sets.test.views.size();
    json["resolution"] = result.resolution;
    json["spacing"] = result.density->voxelSize().x();
    json["voxels_active"] = result.density->activeVoxelCount();
    json["voxels_kept"] = result.keptVoxels;
    if (outcome.confidence.views) json["voxels_seen"] = countOf(*outcome.confidence.views);
    json["bounds"] = bounds.isEmpty() ? Json(nullptr) : Json{listOf(bounds.min), listOf(bounds.max)};
    json["timings"] = {{"read", sets.seconds},
                       {"prepare", result.timings.prepared},
                       {"light", result.timings.light},
                       {"updates", result.timings.updates},
                       {"confidence", outcome.confidenceSeconds},
                       {"compare", outcome.judgement.used.seconds + outcome.judgement.heldOut.seconds +
                                       outcome.judgement.test.seconds + outcome.judgement.directional.seconds}};
    addLight(json, result);
    addHistory(json, result, !a.reference.empty());
    json["view_list"] = views;
    json["warnings"] = outcome.warnings;
    return json;
}

void plotHistory(const std::string& path, const PhotoReconstruction& result) {
    Curve pictures{"RMS difference to the pictures", {}}, opacity{"RMS of opacity to the reference", {}},
        color{"RMS of colour to the reference", {}};
    for (const PhotoPoint& point : result.history) {
        pictures.points.emplace_back(point.updates, point.imageError);
        if (!std::isnan(point.opacity)) opacity.points.emplace_back(point.updates, point.opacity);
        if (!std::isnan(point.color)) color.points.emplace_back(point.updates, point.color);
    }
    plotCurves(path, {"updates", ""}, {pictures, opacity, color});
}

}  // namespace raysweep::apps
