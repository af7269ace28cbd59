// One tile's part in the passes of the methods, by the kernels of the instruction set in use.

#include "solver/disk_contacts.hpp"

namespace nappe {

double DiskContacts::relax_watched(std::size_t tile, std::size_t next, std::vector<BodyVelocity<2>>& u) {
    return kernels_->relax_watched(span(ranges_[tile]), doubles(u), bodies_of(next));
}

StepSums DiskContacts::relax_ahead(std::size_t tile, std::size_t next, double beta, const TermRounding& rounding,
                                   std::vector<BodyVelocity<2>>& u) {
    return kernels_->relax_ahead(span(ranges_[tile]), memory(0, tile), beta, rounding, doubles(u), bodies_of(next));
}

StepSums DiskContacts::relax_along(std::size_t tile, std::size_t next, double beta, const TermRounding& rounding,
                                   std::vector<BodyVelocity<2>>& u) {
    return kernels_->relax_along(span(ranges_[tile]), memory(0, tile), memory(1, tile), beta, rounding, doubles(u),
                                 bodies_of(next));
}

StepSums DiskContacts::project(std::size_t tile, double beta, double step, const TermRounding& rounding,
                               const std::vector<BodyVelocity<2>>& at, std::vector<BodyVelocity<2>>& u) {
    return kernels_->project(span(ranges_[tile]), memory(0, tile), beta, step, rounding, doubles(at), doubles(u));
}

StepSums DiskContacts::gradient(std::size_t tile, const TermRounding& rounding, const std::vector<BodyVelocity<2>>& at,
                                std::vector<BodyVelocity<2>>& of_z) {
    return kernels_->gradient(span(ranges_[tile]), memory(0, tile), memory(1, tile), rounding, doubles(at),
                              doubles(of_z));
}

StepSums DiskContacts::turn(std::size_t tile, double beta, const TermRounding& rounding,
                            const std::vector<BodyVelocity<2>>& at, std::vector<BodyVelocity<2>>& of_p) {
    return kernels_->turn(span(ranges_[tile]), memory(0, tile), memory(1, tile), beta, rounding, doubles(at),
                          doubles(of_p));
}

void DiskContacts::go_along(std::size_t tile, double alpha, std::vector<BodyVelocity<2>>& u) {
    kernels_->go_along(span(ranges_[tile]), memory(1, tile), alpha, doubles(u));
}

void DiskContacts::relax_correction(std::size_t tile, std::size_t next, std::vector<BodyVelocity<2>>& w) {
    const Range& r = ranges_[tile];
    kernels_->relax(BatchSpan{corrections_.data() + r.begin, r.n}, doubles(w), bodies_of(next));
}

void DiskContacts::relax_single(std::size_t tile, std::size_t next, std::vector<BodyVelocity<2, float>>& u) {
    kernels_->relax_single(span(ranges_[tile]), single_of(tile), u.data()->v.data(), bodies_of(next));
}

void DiskContacts::settle_single(std::size_t tile, std::vector<BodyVelocity<2>>& u) {
    kernels_->settle_single(span(ranges_[tile]), single_of(tile), doubles(u));
}

} // namespace nappe
