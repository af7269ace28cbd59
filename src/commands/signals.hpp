#pragma once
// Signals that ask a run to stop.

#include "parallel/communicator.hpp"

namespace nappe {

/// **Local.** From here on a signal to stop (USR1, USR2, TERM, INT, HUP) ends a run after the step in hand, on all ranks at
/// the same one; a second one, more than a second later, ends the process at once. INT and HUP stay ignored if they were.
void catch_signals();

/// **Local.** Whether such a signal has come to this rank.
bool signal_came();

/// **Collective.** Whether one has come to any rank.
bool stop_asked(const Communicator& comm);

} // namespace nappe
