#pragma once
/// Serial lines that one program has to itself.

namespace ninedot {

/// Whoever opens the line from now on is refused (EBUSY), but for root: a console or a second service on it would eat
/// half of what arrives. \param line  descriptor of an open terminal \return  whether, or errno. Threads: any.
bool have_line_alone(int line) noexcept;

/// Before such a line is closed: what was not sent is dropped, and others may open it. Threads: any.
void give_line_back(int line) noexcept;

}  // namespace ninedot
