#pragma once
// What a deposit consists of so far, and whether one more disk can rest on two given supports (core/deposit.cpp).
//
// The frame is that of the deposit: [1] is the height, against gravity. A disk of radius r that touches two supports a
// and b has its centre at one place x(r); n_a and n_b are the unit vectors from the contacts to the centre. It is
// stable if "up" lies between n_a and n_b. As r grows, the centre moves along n_a + n_b, and of the disk's rim the arc
// between the contacts draws back while the rest advances. So whatever forbids a radius also forbids all larger ones
// (an obstacle on the advancing arc, a centre beyond a support) or all smaller ones (an obstacle between the supports,
// too wide a gap). A support may be above the centre: the lowest place in a steep pit often is of that kind, and a pit
// without a place is never filled (tried: with supports from below only, a rough surface kept holes of 30 m).

#include "core/polygon.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace nappe {

/// A disk if >= 0, edge number ~value of the profile if negative. Corners of the profile that point inwards and do not
/// hang over are disks of radius 0.
using SupportId = std::int32_t;

/// Two supports. A disk and an edge can hold another between them on either side of the disk: (disk, edge) is the side
/// ahead in the edge's direction, (edge, disk) the side behind.
struct Site {
    SupportId a = 0;
    SupportId b = 0;
};

enum class Fit { fits, too_small, too_large }; ///< too small: no smaller radius fits either; too large: no larger one

struct Trial {
    Fit fit = Fit::too_small;
    Vec<2> centre = Vec<2>::Zero(); ///< [m], if it fits
};

/// A profile and the disks placed in it, with a grid of cells to find neighbours. Every member is Local.
class Packing {
public:
    /// A polygon without fault, in either orientation.
    Packing(std::vector<Vec<2>> profile, double r_min, double r_max);

    /// Whether a disk of this radius can rest on the two supports, and where.
    Trial try_site(const Site& site, double radius) const;

    /// All pairs that edges and corners of the empty profile form. Overhanging edges take part here only: the first
    /// disk in a corner under a leaning wall is wedged there, and without it nothing could ever rest on the floor
    /// beside it.
    std::vector<Site> sites_of_profile() const;

    /// Adds a disk and returns its number: 0, 1, 2 … after those of the corners.
    SupportId add_disk(const Vec<2>& centre, double radius);

    /// All pairs of a disk with edges and disks of lower number near enough to hold another between them.
    std::vector<Site> sites_of_disk(SupportId disk) const;

private:
    struct Edge {
        Vec<2> start;
        Vec<2> direction; ///< unit; the profile's inside is on its left
        Vec<2> normal;    ///< unit, inwards
        double length;
        bool hangs_over; ///< its inside is below it: perhaps a free surface, so nothing leans against it
    };
    struct Disk {
        Vec<2> centre;
        double radius;
        std::int32_t next; ///< in the same cell, or -1
    };
    /// A disk in touch with both supports, whatever else there may be.
    struct Touch {
        Vec<2> centre;
        Vec<2> n_a;
        Vec<2> n_b;
        Fit fit; ///< of what the two supports alone forbid
    };

    Touch touch_disks(const Site& site, double radius) const;
    Touch touch_disk_and_edge(const Site& site, double radius) const;
    Touch touch_edges(const Site& site, double radius) const;
    Fit beside_edge(const Edge& edge, const Vec<2>& centre, double motion) const;
    static Fit stability(const Touch& touch);
    Fit clearance(const Touch& touch, double radius) const;

    void make_grid();
    void enter_edges_into_grid();
    template <class Visit>
    void for_each_cell_near(const Edge& edge, double reach, Visit visit) const;
    int column(double s) const;
    int row(double z) const;
    std::size_t cell(int column, int row) const { return static_cast<std::size_t>(row) * n_columns_ + column; }

    std::vector<Vec<2>> profile_;
    std::vector<Edge> edges_;
    std::vector<Disk> disks_;
    double r_max_;

    // Cells of at least 2 r_max: disks that touch are in the same or in adjoining ones.
    Vec<2> low_ = Vec<2>::Zero();
    Vec<2> high_ = Vec<2>::Zero();
    double cell_size_ = 0;
    int n_columns_ = 0;
    int n_rows_ = 0;
    std::vector<std::int32_t> newest_disk_;  ///< by cell, or -1
    std::vector<std::int32_t> first_edge_;   ///< by cell, into edge_of_cell_; one more at the end
    std::vector<std::int32_t> edge_of_cell_; ///< edges within 3 r_max of the cell
};

} // namespace nappe
