#pragma once
/// Another program, as a child of this one.
#include <sys/types.h>

#include <string>
#include <vector>

#include "base/result.h"

namespace ninedot {

/// Started as if a person had: no signal blocked or ignored, nothing to read from standard input, no other file of this
/// process open. It leads a process group of its own, so that Ctrl-C is this program's to answer.
/// \param words  the program, looked up as a shell does, and its arguments
/// \param output  descriptor of whoever hears what it prints [1]; -1: nobody does \param errors  the same [1]
/// \return  its process number, to be waited for; errors: kIo where it can't be started
/// Memory: allocates. Threads: pure.
Result<pid_t> start_program(const std::vector<std::string>& words, int output, int errors);

}  // namespace ninedot
