/// From files and options to a scene: scenes are what is in a file, a few numbers, and lights.
#pragma once

#include "raysweep/scene/scene.h"
#include "raysweep/scene/sky_map.h"
#include "raysweep/volume/transfer_function.h"
#include "raysweep/volume/vdb_io.h"

#include <optional>
#include <string>
#include <vector>

namespace raysweep {

/// What makes a solid of a density, and where it is from.
struct Classification {
    TransferFunction function;
    std::string ramp;  ///< "LO,HI[,ALPHA]" where the function is a ramp; empty: it is not
    std::string file;  ///< that the function was read from; empty: none
};

/// How a file's density becomes a medium.
struct MediumOptions {
    std::string density;    ///< grid that is lit, as selectDensity takes it; empty: "density", or the only scalar one
    bool levelSet = false;  ///< it is a level set, and its inside is lit
    bool repair = false;    ///< voxels that light transport cannot work with become 0; albedos, the nearest in [0,1]
    /// Extinction per unit density, 1/world unit, finite and not negative. None: 1, and level sets that are not
    /// classified are solids of the ramp "0,1".
    std::optional<double> extinction;
    std::optional<Classification> classification;  ///< in place of `extinction`: the density becomes a solid
    /// Single-scattering albedo, 1, in [0,1]. None: the colours of `classification`, or 0.9 where it has none.
    std::optional<Color> albedo;
    std::string albedoGrid;    ///< in place of `albedo`, as selectGrid takes it; empty: none
    double albedoScale = 1;    ///< factor on the values of `albedoGrid`, finite and not negative
    double g = 0;              ///< mean cosine of scattering, 1, in (-1,1); other than 0 needs a grey albedo
    std::string emission;      ///< grid of emitted power density, W/world unit^3, as selectGrid takes it; empty: none
    double emissionScale = 1;  ///< factor on `emission`, finite and not negative

    /// True if the medium will be a classified solid.
    bool isClassified() const { return classification || (levelSet && !extinction); }

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

/// Light from all around.
struct SkyOptions {
    Color radiance = grey(0);  ///< W m^-2 sr^-1, finite and not negative; without a map
    std::string map;           ///< file with a lat-long picture of the sky; empty: none
    SkyMapOptions mapping;     ///< how it lies in space

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

struct SceneOptions {
    MediumOptions medium;
    std::vector<Sun> suns;
    std::vector<PointLight> points;
    std::vector<QuadLight> quads;
    SkyOptions sky;

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

/// Voxels that were changed.
struct Repair {
    enum class Kind {
        notFinite,  ///< NaN and infinite ones became 0
        negative,   ///< these and negative ones became 0
        fraction    ///< those outside of [0,1] became the nearest in it, NaN 0
    };
    std::string grid;
    std::size_t voxels = 0;
    Kind kind = Kind::notFinite;
};

/// Suns that stand for bright parts of a sky map.
struct SkySuns {
    int count = 0;
    double share = 0;  ///< of the map's power
};

/// What a scene was made from, and what was assumed.
struct SceneOrigin {
    std::string density;  ///< the grid that was chosen, by a name that chooses it again
    std::optional<Classification> classification;
    bool ownExtinction = false;        ///< the extinction is no multiple of that grid, so files of results must hold it
    std::string nothingOpaque;         ///< why, if the classification leaves no voxel any opacity
    std::optional<SkySuns> skySuns;    ///< none without a map
    std::vector<Repair> repairs;       ///< where there was something to repair
    std::vector<std::string> reasons;  ///< what is modelled and why, one line each; the solver's plan has more
};

struct MediumFromFile {
    Medium medium;
    SceneOrigin origin;
};

struct SceneFromFile {
    Scene scene;
    SceneOrigin origin;
};

/// The medium that the grids of `file` and the options describe. What an earlier lighting added to the file is not
/// seen.
/// @throw InvalidArgument for grids that are missing or not of the kind that is needed, about the option that was to
/// choose them ("density", "albedo", "emission", "g"); for a file written for Blender; and what validate throws
MediumFromFile mediumFrom(const VdbFile& file, const MediumOptions& options = {});

/// The same with lights.
/// @throw InvalidArgument, IoError, about "sky", for a map that cannot be read or used, too
SceneFromFile sceneFrom(const VdbFile& file, const SceneOptions& options = {});

}  // namespace raysweep
