#include "free_set.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

namespace ninedot::codes {
namespace {

Graph graph_of(std::size_t nodes, const std::vector<std::pair<int, int>>& edges) {
  Graph graph(nodes);
  for (const auto& [a, b] : edges)
    graph[static_cast<std::size_t>(a)].push_back(b), graph[static_cast<std::size_t>(b)].push_back(a);
  return graph;
}

TEST(FreeSet, IsTheLargestOfGraphsWhoseLargestIsKnown) {
  std::vector<std::pair<int, int>> ring, petersen;
  for (int i = 0; i < 9; ++i) ring.emplace_back(i, (i + 1) % 9);
  for (int i = 0; i < 5; ++i) {
    petersen.emplace_back(i, (i + 1) % 5), petersen.emplace_back(i, i + 5);
    petersen.emplace_back(i + 5, (i + 2) % 5 + 5);
  }
  for (const auto& [graph, largest] : {std::pair(graph_of(9, ring), 4U), std::pair(graph_of(10, petersen), 4U),
                                       std::pair(graph_of(7, {}), 7U), std::pair(Graph(), 0U)}) {
    const std::vector<int> found = find_free_set(graph, 1000, 1);
    EXPECT_EQ(found.size(), largest);
    for (const int node : found)
      for (const int other : graph[static_cast<std::size_t>(node)])
        EXPECT_EQ(std::ranges::count(found, other), 0) << node << " and " << other;
  }
}

TEST(FreeSet, IsTheSameAtEveryRun) {
  std::vector<std::pair<int, int>> edges;
  for (int a = 0; a < 60; ++a)
    for (int b = 0; b < a; ++b)
      if (a * b % 7 == 3) edges.emplace_back(a, b);
  const Graph graph = graph_of(60, edges);
  EXPECT_EQ(find_free_set(graph, 5000, 3), find_free_set(graph, 5000, 3));
}

}  // namespace
}  // namespace ninedot::codes
