#pragma once
/// A large set of nodes of a graph of which no two are neighbours: for codes that must not resemble each other.
#include <cstdint>
#include <vector>

namespace ninedot::codes {

/// Neighbours of each node: both lists of a pair name the other one, none names itself.
using Graph = std::vector<std::vector<int>>;

/// Searches for `steps` moves of the local search and returns the largest set seen, rising. The same graph, number of
/// steps and seed give the same set with every compiler. Takes about a microsecond a move where nodes have 200
/// neighbours.
std::vector<int> find_free_set(const Graph& graph, std::int64_t steps, std::uint64_t seed);

}  // namespace ninedot::codes
