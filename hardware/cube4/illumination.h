/// Illumination on the machine: a host that loads a medium into voxel memory, lets fronts of rays sweep it (paper,
/// section 2.2), and reads back what was deposited.
#pragma once

#include "cube4/backprojector.h"
#include "cube4/dense_volume.h"
#include "cube4/escape_table.h"
#include "cube4/fixed_point.h"

#include <array>
#include <memory>
#include <optional>
#include <vector>

namespace raysweep::cube4 {

/// How voxels scatter.
enum class ExchangeRule {
    corrected,  ///< docs/illumination.md, eq. L2
    asPrinted   ///< Algorithm 1 as printed: opacity of a voxel's edge, whatever the direction; scatters once
};

/// One wavelength of a medium. Powers are in any one unit.
struct DenseMedium {
    DenseBox box;
    DenseField extinction;             ///< 1/world unit
    DenseField albedo;                 ///< in [0,1]
    std::array<DenseField, 3> normal;  ///< of surfaces, outwards, world space, 0 elsewhere; empty: none
    DenseField source;                 ///< power that every sweep injects in a voxel; empty: none
    DenseField unshot;                 ///< power that is there to be shot before the first sweep; empty: none

    bool isSurface(std::size_t i) const {
        return !normal[0].empty() && (normal[0][i] != 0 || normal[1][i] != 0 || normal[2][i] != 0);
    }

    /// Escape probabilities of this shape of voxel; made when they are first asked for.
    const std::shared_ptr<const EscapeTable>& escapeTable() const {
        if (!table_) table_ = std::make_shared<EscapeTable>(box.worldFromIndex);
        return table_;
    }

  private:
    mutable std::shared_ptr<const EscapeTable> table_;
};

struct IlluminationSetup {
    int pipelines = 16;
    Resampling resampling = Resampling::nearest;
    ExchangeRule rule = ExchangeRule::corrected;
    double zeta = 0.5;    ///< part of its unshot power that a voxel shoots in a sweep, on average over directions
    double mostShot = 1;  ///< the most of it
    bool overlap = true;  ///< see PassOptions
    std::optional<NumberFormat> format;  ///< none: floats
    double largestPower = 1;             ///< of a voxel or a ray, that the format holds
    double largestDeposit = 0;           ///< that will be reached, so far as it is known: sums have to hold it

    /// @throw InvalidArgument naming field, value and bound
    void validate() const;
};

/// One front of rays.
struct SweepFront {
    Vec3 direction{0, 0, 1};          ///< of travel, world space
    double offsetU = 0, offsetV = 0;  ///< of the lattice in the first slice, [0,1)
    double entering = 0;              ///< power of a ray when it enters the box
};

/// What the rays of a front carried at both ends.
struct FrontPower {
    double entered = 0, escaped = 0;
};

/// The machine with a medium in it.
class Illumination {
  public:
    /// @throw InvalidArgument where the medium's numbers do not fit the format
    Illumination(const DenseMedium& medium, const IlluminationSetup& setup);
    ~Illumination();
    Illumination(Illumination&&) noexcept;

    /// Sweeps fronts that all see the same unshot power, one after the other. @param inject sources are added
    std::vector<FrontPower> sweep(const std::vector<SweepFront>& fronts, bool inject, Trace* trace = nullptr);

    DenseField deposit() const;  ///< of all sweeps so far
    DenseField unshot() const;
    double largestPower() const;  ///< that any voxel or ray has had
    const Counters& counters() const;
    std::size_t passes() const;
    /// Bytes in each pipeline: of its memory module; of its compositing buffer and beam buffers.
    std::size_t bytesPerModule() const, bufferBytes() const;

    struct Machine;

  private:
    std::unique_ptr<Machine> machine_;
};

/// The deposit of a front of unit power per ray in a medium that shoots nothing, resampled linearly: direct light.
DenseField directDeposit(const DenseMedium& medium, const IlluminationSetup& setup, const Vec3& direction,
                         FrontPower& power);

/// World area per ray of a front, across it.
double crossSection(const DenseBox& box, const Vec3& direction);

/// Source radiance S = (q + g D / n) / F (docs/illumination.md, eq. L5), in units of power / (world unit^2 sr); 0 at
/// surfaces, whose F has to be measured.
DenseField radiosity(const DenseMedium& medium, const IlluminationSetup& setup, const DenseField& deposit,
                     int injections);

/// Effective albedo g of every voxel.
DenseField effectiveAlbedo(const DenseMedium& medium, ExchangeRule rule);

}  // namespace raysweep::cube4
