// Error against sweeps and time: a cube of 32^3 voxels against a Monte Carlo solution of the same voxels, for several
// settings of the solver. The error is the relative RMS of the averages of blocks of 4^3 voxels, mean over seeds.
#include "raysweep/core/progress.h"
#include "raysweep/illuminate/illuminate.h"

#include "support/blocks.h"
#include "support/volumes.h"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

using namespace raysweep;
using namespace raysweep::test;

namespace {

constexpr int kEdge = 32;
constexpr double kGoal = 0.01;             ///< the error that `summary` asks for
constexpr double kReferenceNoise = 0.002;  ///< of the Monte Carlo solution's blocks, relative RMS
constexpr std::uint64_t kHistories = 4000000;

struct Case {
    const char* name;
    bool sun;  ///< else a constant sky
    double opticalThickness;
    float albedo;
};
const Case kCases[] = {{"sun 4 0.9", true, 4, 0.9f},     {"sky 4 0.9", false, 4, 0.9f},
                       {"sun 1 0.9", true, 1, 0.9f},     {"sky 1 0.9", false, 1, 0.9f},
                       {"sun 16 0.99", true, 16, 0.99f}, {"sky 16 0.99", false, 16, 0.99f}};

/// Settings are written as "key=value key=value"; what is not named is the solver's default.
const char* const kSettings[] = {"default",          "coarse=0", "coarse=0 zeta=1",     "beams=1",
                                 "beams=1 zeta=0.2", "beams=8",  "interpolation=linear"};
const int kFewSettings = 2;  ///< enough where the thickness is not 4
const double kTolerances[] = {0.03, 0.01, 0.003};
const int kSweeps[] = {8,  12, 16, 20, 24,  28,  32,  36,  40,  44,  48,  56,  64,
                       72, 80, 88, 96, 112, 128, 160, 192, 224, 256, 320, 384, 512};

struct Arguments {
    int seeds = 8, mostSweeps = 512;
    std::vector<std::string> cases, settings;
    std::string cache = (std::filesystem::temp_directory_path() / "raysweep-reference").string(), summary;
};

struct Reference {
    std::vector<double> blocks;
    double noise = 0;  ///< its own share of every error
};

struct Point {
    double sweeps = 0, finishing = 0, seconds = 0, error = 0, worst = 0;
    double all() const { return sweeps + finishing; }
};

Scene sceneOf(const Case& c) {
    Scene scene;
    scene.medium.density = boxVolume(Index3(kEdge));
    scene.medium.extinctionScale = c.opticalThickness / kEdge;
    scene.medium.albedo = grey(c.albedo);
    if (c.sun)
        scene.suns.push_back({Vec3(0.3, -1, 0.2), grey(1)});
    else
        scene.sky.radiance = grey(1);
    return scene;
}

std::vector<double> blocksOf(const std::vector<double>& voxels) {
    return blockAverages(voxels, std::vector<double>(voxels.size(), 1.0), Index3(kEdge));
}

/// Independent runs until their spread says that the noise of their mean is low enough.
Reference computeReference(const Case& c) {
    const McScene scene = monteCarloScene(sceneOf(c));
    Reference result{std::vector<double>(blocksOf(std::vector<double>(kEdge * kEdge * kEdge)).size(), 0.0), 1};
    double squares = 0;
    for (int runs = 1; runs < 4 || result.noise > kReferenceNoise; ++runs) {
        const std::vector<double> run = blocksOf(monteCarlo(scene, kHistories, std::uint64_t(runs)).sourceRadiance);
        double norm = 0;
        for (std::size_t b = 0; b < run.size(); ++b) {
            const double change = run[b] - result.blocks[b];
            result.blocks[b] += change / runs;
            squares += change * (run[b] - result.blocks[b]);  // Welford: sum of squared distances from the mean
            norm += result.blocks[b] * result.blocks[b];
        }
        if (runs > 1) result.noise = std::sqrt(squares / (runs - 1.0) / runs / norm);
    }
    return result;
}

/// From the cache, else computed and put there. The first line is the noise.
Reference referenceOf(const Case& c, const std::string& folder) {
    std::string name = c.name;
    std::replace(name.begin(), name.end(), ' ', '-');
    const std::filesystem::path path = std::filesystem::path(folder) / ("cube-" + name + ".csv");
    Reference result;
    if (std::ifstream file(path); file >> result.noise) {
        for (double value; file >> value;) result.blocks.push_back(value);
        return result;
    }
    const Timer timer;
    result = computeReference(c);
    std::fprintf(stderr, "reference of %s: noise %.2f %%, %.0f s\n", c.name, 100 * result.noise, timer.seconds());
    std::filesystem::create_directories(folder);
    std::ofstream file(path);
    file.precision(9);
    file << result.noise << "\n";
    for (const double value : result.blocks) file << value << "\n";
    return result;
}

template <class Value>
Value oneOf(const std::map<std::string, Value>& names, const std::string& name) {
    const auto found = names.find(name);
    if (found == names.end()) throw std::invalid_argument("unknown value '" + name + "' in a setting");
    return found->second;
}

void apply(IlluminateOptions& options, const std::string& key, const std::string& value) {
    if (key == "zeta")
        options.zeta = std::stod(value);
    else if (key == "beams")
        options.beams = std::stoi(value);
    else if (key == "coarse")
        options.darkStart = value == "0";
    else if (key == "batch")
        options.batch = std::stoi(value);
    else if (key == "unshot")
        options.unshotShare = std::stod(value);
    else if (key == "interpolation")
        options.interpolation =
            oneOf<Interpolation>({{"nearest", Interpolation::nearest}, {"linear", Interpolation::linear}}, value);
    else if (key == "directions")
        options.directions =
            oneOf<DirectionSet>({{"fibonacci", DirectionSet::fibonacci}, {"random", DirectionSet::random}}, value);
    else if (key == "remaining")
        options.remaining = oneOf<Remaining>(
            {{"shoot", Remaining::shoot}, {"drop", Remaining::drop}, {"spread", Remaining::spread}}, value);
    else
        throw std::invalid_argument("unknown key '" + key + "' in a setting");
}

IlluminateOptions optionsOf(const std::string& setting) {
    IlluminateOptions options;
    std::istringstream words(setting == "default" ? "" : setting);
    for (std::string word; words >> word;) {
        const std::size_t equals = word.find('=');
        if (equals == std::string::npos) throw std::invalid_argument("'" + word + "' is not of the form key=value");
        apply(options, word.substr(0, equals), word.substr(equals + 1));
    }
    return options;
}

/// Means over the seeds; the median of the times, since the machine may do other work.
Point measure(const Scene& scene, const Reference& reference, IlluminateOptions options, int seeds) {
    Point point;
    std::vector<double> seconds;
    for (int seed = 1; seed <= seeds; ++seed) {
        options.seed = std::uint64_t(seed);
        const Timer timer;
        const Illumination lit = illuminate(scene, options);
        seconds.push_back(timer.seconds());
        const DenseVolume radiosity = dense(*lit.radiosity, *scene.medium.density, 0);
        const double error = relativeRms(blocksOf(radiosity.values), reference.blocks);
        point.sweeps += double(lit.sweeps) / seeds;
        point.finishing += double(lit.finishingSweeps) / seeds;
        point.error += error / seeds;
        point.worst = std::max(point.worst, error);
    }
    std::nth_element(seconds.begin(), seconds.begin() + seeds / 2, seconds.end());
    point.seconds = seconds[std::size_t(seeds / 2)];
    return point;
}

void print(const Case& c, const std::string& setting, double tolerance, const Point& p) {
    std::printf("%s,%s,%g,%g,%g,%g,%.6g,%.6g,%.6g\n", c.name, setting.c_str(), tolerance, p.sweeps, p.finishing,
                p.all(), p.seconds, p.error, p.worst);
    std::fflush(stdout);
}

/// What a user gets who asks for a tolerance.
void measureTolerances(const Case& c, const Reference& reference, const Arguments& arguments) {
    for (const double tolerance : kTolerances) {
        IlluminateOptions options;
        options.tolerance = tolerance;
        print(c, "default", tolerance, measure(sceneOf(c), reference, options, arguments.seeds));
    }
}

/// More and more sweeps. @return one point for each number of them
std::vector<Point> measureSweeps(const Case& c, const Reference& reference, const std::string& setting,
                                 const Arguments& arguments) {
    IlluminateOptions options = optionsOf(setting);
    options.tolerance = 0;
    std::vector<Point> points;
    for (const int sweeps : kSweeps) {
        if (sweeps > arguments.mostSweeps) break;
        options.sweeps = sweeps;
        points.push_back(measure(sceneOf(c), reference, options, arguments.seeds));
        print(c, setting, 0, points.back());
    }
    return points;
}

/// The fewest sweeps in all that reach the goal; empty fields if none do. The least error says how near they come.
std::string summaryLine(const Case& c, const std::string& setting, const std::vector<Point>& points) {
    const Point* first = nullptr;
    double least = INFINITY;
    for (const Point& point : points) {
        if (point.error <= kGoal && (!first || point.all() < first->all())) first = &point;
        least = std::min(least, point.error);
    }
    std::ostringstream line;
    line << c.name << "," << setting << ",";
    if (first)
        line << first->sweeps << "," << first->finishing << "," << first->all() << "," << first->seconds;
    else
        line << ",,,";
    line << "," << least << "\n";
    return line.str();
}

std::vector<std::string> settingsOf(const Case& c, const Arguments& arguments) {
    if (!arguments.settings.empty()) return arguments.settings;
    const std::vector<std::string> all(std::begin(kSettings), std::end(kSettings));
    return c.opticalThickness == 4 ? all : std::vector<std::string>(all.begin(), all.begin() + kFewSettings);
}

void run(const Arguments& arguments) {
    std::string summary = "case,setting,sweeps,finishing,all,seconds,least_error\n";
    std::printf("case,setting,tolerance,sweeps,finishing,all,seconds,error,worst\n");
    for (const Case& c : kCases) {
        const auto& chosen = arguments.cases;
        if (!chosen.empty() && std::find(chosen.begin(), chosen.end(), c.name) == chosen.end()) continue;
        const Reference reference = referenceOf(c, arguments.cache);
        measureTolerances(c, reference, arguments);
        for (const std::string& setting : settingsOf(c, arguments))
            summary += summaryLine(c, setting, measureSweeps(c, reference, setting, arguments));
    }
    if (arguments.summary.empty())
        std::fputs(summary.c_str(), stderr);
    else
        std::ofstream(arguments.summary) << summary;
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("Error against sweeps and time, as CSV");
    Arguments arguments;
    std::vector<std::string> names;
    for (const Case& c : kCases) names.push_back(c.name);
    app.add_option("--case", arguments.cases, "Light, optical thickness and albedo (default: all)")
        ->check(CLI::IsMember(names));
    app.add_option("--setting", arguments.settings, "\"default\" or \"key=value ...\" (default: a list)");
    app.add_option("--seeds", arguments.seeds)->check(CLI::PositiveNumber)->capture_default_str();
    app.add_option("--most-sweeps", arguments.mostSweeps, "Injecting")->capture_default_str();
    app.add_option("--cache", arguments.cache, "Folder in which Monte Carlo references are kept")
        ->capture_default_str();
    app.add_option("--summary", arguments.summary, "File for the fewest sweeps that reach 1 % (default: stderr)");
    CLI11_PARSE(app, argc, argv);
    try {
        run(arguments);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "raysweep_convergence: %s\n", e.what());
        return 1;
    }
}
