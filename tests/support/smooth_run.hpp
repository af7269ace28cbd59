#pragma once
// What tests of smooth contacts share: disks of one size on springs without dashpots.

#include "support/serial_run.hpp"

#include <limits>
#include <numbers>

namespace nappe::test::smooth {

inline constexpr double g = standard_gravity, pi = std::numbers::pi;
inline constexpr double ulp = std::numeric_limits<double>::epsilon();
inline constexpr double r = 0.5, k = 4e6;
inline const double m = disk_mass(r);

/// Springs between all that is there; without dashpots unless told.
inline Scene<2>& with_springs(SceneBuilder& b, double k_s = 0, double c_n = 0, double c_s = 0) {
    for (auto& law : b.scene().laws) {
        law.springs = Springs{{k, c_n}, {k_s, c_s}};
    }
    return b.scene();
}

/// On all ranks that the test runs on. Tests of thousands of steps take SerialRun: each rank runs them whole.
class WorldRun : public SerialRun {
public:
    explicit WorldRun(const Scene<2>& scene) : SerialRun(scene, nullptr, MPI_COMM_WORLD) {}
};

} // namespace nappe::test::smooth
