#pragma once
/// Work on what somebody else has written, in a process of its own, which may have fewer rights: whatever a text could
/// do to its reader it does to that process.
#include <functional>
#include <string>

namespace ninedot {

/// \param user  whose rights it has; empty: the caller's \param name  of the work, for errors: "the check"
/// \return  what `work` returned
/// Throws StartupError: kWrongUsage, no such user; kWorkFailed, it did not come to its end within a minute; and what
/// `work` throws, with its text and status. Memory: 1 MB of text at most. Threads: call it while there is one only.
std::string in_child(const std::string& user, const std::string& name, const std::function<std::string()>& work);

}  // namespace ninedot
