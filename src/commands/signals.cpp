#include "commands/signals.hpp"

#include <csignal>
#include <ctime>

namespace nappe {

namespace {

volatile std::sig_atomic_t caught = 0;
volatile double caught_at = 0; // [s]

double monotonic_seconds() {
    struct timespec now {};
    ::clock_gettime(CLOCK_MONOTONIC, &now); // may be called here
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void remember_signal(int number) {
    const double now = monotonic_seconds();
    if (caught == 0) {
        caught_at = now;
        caught = number;
    } else if (now - caught_at > 1) { // else the same one by two ways: a batch system's and mpirun's
        std::signal(number, SIG_DFL);
        std::raise(number);
    }
}

} // namespace

void catch_signals() {
    struct sigaction action {};
    action.sa_handler = remember_signal;
    for (const int number : {SIGUSR1, SIGUSR2, SIGTERM}) {
        sigaction(number, &action, nullptr);
    }
    for (const int number : {SIGINT, SIGHUP}) { // nohup, or a shell's background
        struct sigaction before {};
        sigaction(number, nullptr, &before);
        if (before.sa_handler != SIG_IGN) {
            sigaction(number, &action, nullptr);
        }
    }
    std::signal(SIGPIPE, SIG_IGN);
}

bool signal_came() {
    return caught != 0;
}

bool stop_asked(const Communicator& comm) {
    return comm.bit_or(signal_came() ? 1U : 0U) != 0;
}

} // namespace nappe
