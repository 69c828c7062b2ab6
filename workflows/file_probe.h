#pragma once
/// \file
/// A guard against files that bring down what reads them.

#include <functional>
#include <string>

namespace trame::workflows {

/// Runs `read` in a child process: HDF5 follows damaged pointers of a file into crashes and endless loops, which no
/// check of ours can foresee. Throws InputError that begins with `name` if the child ends by a signal, takes more
/// than `seconds` of computing, or waits for much longer than that. What `read` throws or prints is for the next
/// reading, in this process, to tell. To be called while the process has one thread.
void probe(const std::string& name, const std::function<void()>& read, unsigned seconds = 60);

/// To be called by `read` in the child: it may compute for so many seconds from now on, whatever it took up to here.
void allow_seconds(unsigned seconds);

}  // namespace trame::workflows
