#pragma once
// The first of the two steps that make a sample: a compact deposit found by geometry alone, without forces. Relaxing it
// under gravity is the second, and the business of a settling stage.

#include "core/rows.hpp"
#include "core/scene.hpp"

#include <vector>

namespace nappe {

/// No deposit in this profile has more grains: a bound by its area and smallest radius, in the time of a glance. Local.
double most_grains(const Sample<2>& sample);

/// What a deposit may hold: GlobalIds go further, but one rank makes it.
inline constexpr double most_deposited = 1e9; // messages say so too

/// Fills a profile with disks from below. Each disk rests on two supports (disks, edges or corners of the profile) that
/// hold it between them, so that it can not roll down; whole disks lie inside the profile; no overlap exceeds 1e-9 of a
/// radius.
///
/// The k-th disk drawn has its radius from random number k of (sample.seed, deposit_radius). Of the places free for it,
/// it takes the one of the least height + random part of half the largest radius (deposit_sites.hpp says why), heights
/// compared at the mean radius of its size class, a fiftieth of the largest radius wide; ties go to the pair of
/// supports placed first. A radius that fits nowhere is left out; 1000 of those in a row, or no place left for any
/// radius, end the filling. So all radii drawn are placed until the profile is full to its top; from then on only those
/// that fit in a hole that is left, at any depth. The law of radii is kept if those are few, which is so where no radius
/// is much smaller than another: of 3 m² and radii up to 0.025 m the mean radius is 0.992 of the law's for a smallest
/// radius of 1/2 of the largest, 0.982 for 1/3, 0.964 for 1/4, and 0.911 for 1/5, where of eight equal classes of radius
/// the smallest has over twice the disks of each of the others but the next (859, 453, 389, 452, 390, 395, 383, 381).
///
/// `density` [kg/m³] gives the masses; `gravity` [m/s²] gives what is low, its length does not matter. Heights of
/// layers are measured against it: for gravity along −y, layer_tops are values of y.
/// Rows have ids 0 … n−1 by strips across gravity, 16 largest radii wide, within a strip in order of placement:
/// neighbours in space are near in memory. Velocity, spin and rotation are 0.
///
/// Local; the same rows on every machine (positions use + − × ÷ and square roots only). InputError: radii not positive
/// or not in order, density not positive, no gravity, a profile that is no polygon, is too small for a single disk, or
/// holds over 10⁹.
std::vector<GrainRow<2>> deposit(const Sample<2>& sample, double density, const Vec<2>& gravity);

} // namespace nappe
