#include "light_options.h"
#include "hints.h"

#include <algorithm>
#include <map>

namespace raysweep::apps {
namespace {

const std::map<std::string, Interpolation> kInterpolations = {{"nearest", Interpolation::nearest},
                                                              {"linear", Interpolation::linear}};
const std::map<std::string, Exchange> kExchanges = {{"auto", Exchange::automatic},
                                                    {"medium", Exchange::medium},
                                                    {"surface", Exchange::surface},
                                                    {"paper", Exchange::paper}};
const std::map<std::string, Remaining> kRemaining = {
    {"shoot", Remaining::shoot}, {"drop", Remaining::drop}, {"spread", Remaining::spread}};
const std::map<std::string, DirectionSet> kDirectionSets = {{"fibonacci", DirectionSet::fibonacci},
                                                            {"random", DirectionSet::random},
                                                            {"low-discrepancy", DirectionSet::lowDiscrepancy}};
/// Tolerances of the named qualities; `preview` is the default tolerance.
const std::map<std::string, double> kQualities = {{"draft", 0.03}, {"preview", 0.01}, {"final", 0.003}};

const char* const kDefaultAlbedo = "0.9";

/// The default is what `value` is.
template <class Value>
CLI::Option* addChoice(CLI::App& app, const std::string& name, Value& value,
                       const std::map<std::string, Value>& choices, const std::string& help) {
    const auto isDefault = [&](const auto& choice) { return choice.second == value; };
    return app
        .add_option_function<std::string>(
            name, [&value, &choices](const std::string& text) { value = choices.at(text); }, help)
        ->check(CLI::IsMember(choices).description(""))
        ->default_str(std::find_if(choices.begin(), choices.end(), isDefault)->first);
}

void addMediumOptions(CLI::App& app, LightArguments& a) {
    MediumOptions& medium = a.scene.medium;
    app.option_defaults()->group("Volume");
    app.add_option(
           "--density", medium.density,
           "Grid that is lit; 'NAME[1]' is the second of that name (default: density, else the only float grid)")
        ->type_name("NAME");
    auto* const extinction = app.add_option("--extinction", medium.extinction,
                                            "Extinction per unit density, 1/world unit: how thick the volume is")
                                 ->default_str("1");
    addTransferOptions(app, a.transfer, extinction);
    app.add_flag("--from-level-set", medium.levelSet,
                 "The density grid is a level set: light its inside, a solid of opacity 0.99 per voxel; with "
                 "--extinction a fog");
    app.add_flag("--repair", medium.repair,
                 "Set NaN, infinite and negative voxels to 0, and albedos to the nearest in [0,1], instead of "
                 "refusing them");
    app.add_option(
           "--albedo", a.albedo,
           "Part of the light that is scattered on where it meets the volume, in [0,1]: one number, R,G,B, or a grid "
           "(of any transform); takes the place of colours of --transfer")
        ->default_str(kDefaultAlbedo)
        ->type_name("A|grid:NAME");
    app.add_option("--albedo-scale", medium.albedoScale, "Factor on the values of --albedo grid:NAME")
        ->capture_default_str();
    app.add_option(
           "--g", medium.g,
           "Mean cosine of scattering (Henyey-Greenstein), in (-1,1): above 0 forwards, as in clouds; needs a grey "
           "albedo")
        ->capture_default_str();
    auto* const emission =
        app.add_option(
               "--emission", a.emission,
               "Grid of emitted power density, W/unit^3, float or vec3s, of any resolution and transform, in the "
               "smoke or beside it; what it gives off is written as grid 'emission' and shown apart from "
               "radiosity")
            ->type_name("grid:NAME");
    app.add_option("--fire", a.fire, "The same: a grid, by its name alone")->type_name("NAME")->excludes(emission);
    app.add_option("--emission-scale", medium.emissionScale, "Factor on --emission or --fire")->capture_default_str();
}

void addLightSourceOptions(CLI::App& app, LightArguments& a) {
    app.option_defaults()->group("Light");
    app.add_option("--sun", a.suns,
                   "Parallel light travelling along DX,DY,DZ; E: irradiance at normal incidence, W/unit^2, or E:R:G:B "
                   "(times a colour); repeatable")
        ->allow_extra_args(false)
        ->type_name("DX,DY,DZ,E");
    app.add_option("--point", a.points,
                   "Point light, inside or outside the volume; P: power, W, or P:R:G:B; repeatable")
        ->allow_extra_args(false)
        ->type_name("X,Y,Z,P");
    app.add_option(
           "--quad", a.quads,
           "Area light: corner O, edges U and V, shining towards U x V with radiance L (or L:R:G:B); lights but "
           "is not seen; repeatable")
        ->allow_extra_args(false)
        ->type_name("OX,OY,OZ,UX,UY,UZ,VX,VY,VZ,L");
    addSkyOptions(app, a.sky);
}

void addSolverOptions(CLI::App& app, LightArguments& a) {
    app.option_defaults()->group("Solver");
    IlluminateOptions& o = a.options;
    addChoice(app, "--exchange", o.exchange, kExchanges,
              "What voxels and rays exchange; auto: surfaces in solids (--ramp, --transfer, level sets), else medium; "
              "paper: Algorithm 1 as printed")
        ->type_name("auto|medium|surface|paper");
    app.add_option("--surface-threshold", o.surfaceThreshold,
                   "A voxel of a solid is a surface where opacity changes by more than this per voxel and what "
                   "is behind it is opaque, (0,1]")
        ->capture_default_str();
    app.add_option("--tolerance", a.tolerance,
                   "Stop when 20 sweeps or more change the answer by less than this part (RMS of radiosity); 0: never "
                   "(default: 0.01)")
        ->type_name("T");
    app.add_option(
           "--sweeps", o.sweeps,
           "Most sweeps; with --tolerance 0 the exact number; 0: light of suns and points alone, scattered once")
        ->capture_default_str();
    app.add_option("--quality", a.quality, "The tolerance by name: 0.03, 0.01 or 0.003; --tolerance wins")
        ->check(CLI::IsMember(kQualities).description(""))
        ->type_name("draft|preview|final");
    app.add_option("--resolution", a.resolution,
                   "Solve on a grid F times as fine, (0,1]: 0.5 has voxels twice as long, and takes an eighth of the "
                   "time and memory or a little more")
        ->type_name("F")
        ->capture_default_str();
    app.add_option(
        "--zeta", o.zeta,
        "Part of a voxel's unshot power that the directions swept together shoot, (0,1]; unless given 0.1 or 0.2 from "
        "a coarse start, else 0.5");
    app.add_option(
           "--beams", o.beams,
           "Directions that are swept together, 1 to 8: more is quicker, and a little less accurate for the same "
           "number of sweeps; 0: chosen. Random and low-discrepancy directions go one by one")
        ->capture_default_str();
    app.add_flag("--dark-start", o.darkStart,
                 "Do not begin (and end) with a solution on voxels twice as long, as media do");
    addChoice(app, "--interpolation", o.interpolation, kInterpolations, "How rays and voxels meet")
        ->type_name("nearest|linear");
    addChoice(app, "--remaining", o.remaining, kRemaining,
              "What becomes of light that is still under way after the last sweep")
        ->type_name("shoot|drop|spread");
    app.add_option("--unshot", o.unshotShare,
                   "--remaining shoot ends when less than this part of all light is under way")
        ->capture_default_str();
    addChoice(app, "--directions", o.directions, kDirectionSets, "How sweep directions are chosen")
        ->type_name("fibonacci|random|low-discrepancy");
    app.add_option(
           "--batch", o.batch,
           "Directions of the first Fibonacci batch, about; each later one is as large as all before it; 0: chosen")
        ->capture_default_str();
}

void addOutputOptions(CLI::App& app, LightArguments& a) {
    app.option_defaults()->group("Output");
    app.add_flag(
        "--upsample", a.upsample,
        "With --resolution: interpolate radiosity to the voxels of the input, for programs that need it there");
    app.add_flag("--half", a.half, "Save radiosity and unshot as half floats: half the size, values up to 65504");
    app.add_option("--snapshots", a.snapshots,
                   "Also write the answer so far every N sweeps, as OUT_0020.vdb and so on; 0: no")
        ->capture_default_str()
        ->check(CLI::Range(0, 1000000).description(""))
        ->type_name("N");
    app.add_option("--plot", a.plot, "Draw the convergence (needs gnuplot)")->type_name("FILE.svg|.png");
    app.add_option("--record", a.record,
                   "Write all that it takes to make the same sweeps again, to this file and to RUN.vdb beside it")
        ->type_name("RUN.json");
    app.add_flag("--explain", a.explain, "Say what will be modelled and why, and stop; needs no -o");
}

/// "E" or "E:R:G:B" for strength times colour.
Color parseStrength(const std::string& text, const std::string& option, const std::string& example) {
    const std::vector<std::string> parts = split(text, ':');
    if (parts.size() != 1 && parts.size() != 4)
        usageError(option, "'" + text + "': one number or E:R:G:B is needed, as in " + option + " " + example);
    const double strength = parseNumber(parts[0], option, example);
    if (strength < 0) usageError(option, "'" + text + "': light cannot be negative");
    Color color = grey(float(strength));
    for (std::size_t i = 1; i < parts.size(); ++i)
        color[int(i) - 1] = float(strength * parseNumber(parts[i], option, example));
    if (std::min({color.x, color.y, color.z}) < 0) usageError(option, "'" + text + "': light cannot be negative");
    return color;
}

struct Light {
    Vec3 vector;
    Color strength;
};

enum class Vector { direction, point };

/// Three coordinates and a strength.
Light parseLight(const std::string& text, const std::string& option, const std::string& example, Vector kind) {
    const std::vector<std::string> parts = split(text, ',');
    if (parts.size() != 4)
        usageError(option, "'" + text + "': four values are needed, as in " + option + " " + example);
    Light light;
    const std::string vector = parts[0] + "," + parts[1] + "," + parts[2];
    light.vector =
        kind == Vector::direction ? parseDirection(vector, option, example) : parseVec3(vector, option, example);
    light.strength = parseStrength(parts[3], option, example);
    return light;
}

std::string gridName(const std::string& text, const std::string& option) {
    const std::string prefix = "grid:";
    if (text.rfind(prefix, 0) != 0 || text == prefix) usageError(option, "'" + text + "': grid:NAME is needed");
    return text.substr(prefix.size());
}

bool namesGrid(const std::string& text) {
    return text.rfind("grid:", 0) == 0;
}

std::vector<Sun> parseSuns(const LightArguments& a) {
    std::vector<Sun> suns;
    for (const std::string& text : a.suns) {
        const Light light = parseLight(text, "--sun", "0.3,-1,0.2,3", Vector::direction);
        suns.push_back({light.vector, light.strength});
    }
    return suns;
}

std::vector<PointLight> parsePoints(const LightArguments& a) {
    std::vector<PointLight> points;
    for (const std::string& text : a.points) {
        const Light light = parseLight(text, "--point", "0,0,5,100", Vector::point);
        points.push_back({light.vector, light.strength});
    }
    return points;
}

std::vector<QuadLight> parseQuads(const LightArguments& a) {
    const std::string example = "-1,5,-1,0,0,2,2,0,0,3";
    std::vector<QuadLight> quads;
    for (const std::string& text : a.quads) {
        const std::vector<std::string> parts = split(text, ',');
        if (parts.size() != 10)
            usageError(
                "--quad",
                "'" + text + "': corner, two edges and a radiance, ten values, are needed, as in --quad " + example);
        double at[9];
        for (std::size_t i = 0; i < 9; ++i) at[i] = parseNumber(parts[i], "--quad", example);
        QuadLight quad{{at[0], at[1], at[2]},
                       {at[3], at[4], at[5]},
                       {at[6], at[7], at[8]},
                       parseStrength(parts[9], "--quad", example)};
        if (quad.u.cross(quad.v).length() == 0)
            usageError("--quad", "'" + text + "': the quad has no area: its edges are parallel, or one has no length");
        quads.push_back(quad);
    }
    return quads;
}

/// What is written: OUT.vdb and its snapshots.
std::vector<std::string> outputsOf(const LightArguments& a, const std::string& output) {
    constexpr int kMost = 10000;
    std::vector<std::string> files{output};
    for (int n = 1; a.snapshots > 0 && n <= std::min(kMost, a.options.sweeps / a.snapshots); ++n)
        files.push_back(numberedName(output, n * a.snapshots));
    return files;
}

/// Those of sky and transfer function are where their options are.
void addFileRoles(CLI::App& app, const LightArguments& a) {
    reads(app.get_option("input"));
    writes(app.get_option("--output"), [&a](const std::string& output) { return outputsOf(a, output); });
    writes(app.get_option("--plot"));
    writes(app.get_option("--record"), recordFiles);
}

}  // namespace

void addLightOptions(CLI::App& app, LightArguments& a) {
    app.add_option("input", a.input, "Volume to light")->required()->type_name("IN.vdb");
    app.add_option("-o,--output", a.output,
                   "Lit volume: all grids of the input, and radiosity, unshot and emission, in place of earlier ones")
        ->type_name("OUT.vdb");
    addMediumOptions(app, a);
    addLightSourceOptions(app, a);
    addSolverOptions(app, a);
    addOutputOptions(app, a);
    addCommonOptions(app, a.common);
    addFileRoles(app, a);
    app.footer("Example:\n  raysweep light smoke.vdb -o lit.vdb --extinction 0.12 --sun 0.3,-1,0.2,3 --sky 0.3\n");
}

void completeOptions(LightArguments& a, const CLI::App& command) {
    if (!a.explain || !a.output.empty()) requireFileOutput(a.output);
    if (!a.record.empty()) requireRecordName(a.record);
    IlluminateOptions& o = a.options;
    if (!a.quality.empty()) o.tolerance = kQualities.at(a.quality);
    if (a.tolerance) o.tolerance = *a.tolerance;
    o.seed = a.common.seed;
    if (!(a.resolution > 0 && a.resolution <= 1)) usageError("--resolution", "must be above 0 and at most 1");
    MediumOptions& medium = a.scene.medium;
    if (a.upsample && a.resolution == 1) usageError("--upsample", "is for --resolution below 1 only");
    a.scene.sky = parseSky(a.sky);
    parseRamp(a.transfer);
    if (namesGrid(a.albedo))
        medium.albedoGrid = gridName(a.albedo, "--albedo");
    else if (!a.albedo.empty())
        medium.albedo = parseColor(a.albedo, "--albedo");
    if (medium.albedoScale != 1 && !namesGrid(a.albedo))  // config files that were written say all defaults
        usageError("--albedo-scale", "is for --albedo grid:NAME");
    if (medium.albedo && !isGrey(*medium.albedo) && medium.g != 0)
        usageError("--g", "needs a grey albedo, one number, since extinction is one for all wavelengths");
    if (!a.emission.empty()) medium.emission = gridName(a.emission, "--emission");
    if (!a.fire.empty()) medium.emission = namesGrid(a.fire) ? gridName(a.fire, "--fire") : a.fire;
    a.scene.suns = parseSuns(a);
    a.scene.points = parsePoints(a);
    a.scene.quads = parseQuads(a);
    requireValid(command, [&] {
        o.validate();
        a.scene.validate();
    });
}

}  // namespace raysweep::apps
