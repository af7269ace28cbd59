#pragma once
// What a scene asks for beyond disks without friction that hit inelastically: all that is stored or computed for the
// sake of one feature hangs on its flag here.

#include "core/scene.hpp"

namespace nappe {

struct Features {
    bool friction = true;       ///< some law has mu > 0
    bool mixed_friction = true; ///< and laws differ in it
    bool restitution = true;    ///< some law has e > 0
    bool cohesion = true;       ///< some law attracts
    bool turning = true;        ///< some grain may turn: there is friction, or a spin is given
    bool cells = true;          ///< sets of grains are marked when loading starts
    bool layers = true;         ///< grains are of more than one layer
    bool kept_normals = true;   ///< normals serve for several substeps
    bool kept_gaps = true;      ///< that, or positions are corrected, or contacts are smooth
    bool correction = true;     ///< positions are corrected
    bool driven_walls = true;
    bool adaptive = true;    ///< quiet tiles are left alone
    bool single = true;      ///< sweeps go over rounded copies
    bool smooth = true;      ///< some stage has springs and dashpots in place of rigid contacts
    int impulses_kept = 2;   ///< by the method that keeps most from sweep to sweep: so many of every contact
    int velocities_kept = 2; ///< and of every body
};

/// Local.
template <int D>
Features features_of(const Scene<D>& scene);

} // namespace nappe
