// Local search on plateaus, as in Andrade, Resende & Werneck, "Fast local search for the maximum independent set
// problem", Journal of Heuristics 18 (2012): whatever has no neighbour in the set joins it; where there is nothing
// like that, a node with one neighbour in the set takes that one's place, which changes what is free. Now and then any
// node is forced in and all of its neighbours out, or the search would walk in circles.
#include "free_set.h"

#include <algorithm>
#include <array>
#include <random>

namespace ninedot::codes {
namespace {

// Both chosen for the sets of codes by trying: 1, 5, 30, 200 draws; a kick in 20, 100, 500, 3000, 10000 steps, or none.
constexpr int kDraws = 5;
constexpr std::uint64_t kStepsPerKick = 3000;

class Search {
 public:
  Search(const Graph& graph, std::uint64_t seed) : graph_(graph), nodes_(graph.size()), random_(seed) {
    for (int node = 0; node < count(); ++node) sort_in(node);
  }

  void step() {
    ++now_;
    if (std::vector<int>& free = outside_[0]; !free.empty())
      join(draw(free));
    else if (outside_[1].empty() || random_() % kStepsPerKick == 0)
      force_in(static_cast<int>(random_() % nodes_.size()));
    else
      force_in(longest_outside_of_a_few());
  }

  std::size_t size() const { return size_; }
  std::vector<int> members() const {
    std::vector<int> found;
    for (int node = 0; node < count(); ++node)
      if (at(node).is_member) found.push_back(node);
    return found;
  }

 private:
  struct Node {
    bool is_member = false;
    int members_beside = 0;
    int list = -1;  ///< which of outside_ it is in; -1: none
    std::size_t place = 0;
    std::int64_t left_at = 0;
  };

  int count() const { return static_cast<int>(nodes_.size()); }
  Node& at(int node) { return nodes_[static_cast<std::size_t>(node)]; }
  const Node& at(int node) const { return nodes_[static_cast<std::size_t>(node)]; }
  const std::vector<int>& beside(int node) const { return graph_[static_cast<std::size_t>(node)]; }

  // Not uniform_int_distribution, which every library makes differently.
  int draw(const std::vector<int>& list) { return list[random_() % list.size()]; }

  int longest_outside_of_a_few() {
    int chosen = draw(outside_[1]);
    for (int i = 1; i < kDraws; ++i)
      if (const int other = draw(outside_[1]); at(other).left_at < at(chosen).left_at) chosen = other;
    return chosen;
  }

  void force_in(int node) {
    if (at(node).is_member) return;
    for (const int other : beside(node))
      if (at(other).is_member) leave(other);
    join(node);
  }
  void join(int node) {
    at(node).is_member = true, ++size_;
    sort_in(node);
    for (const int other : beside(node)) ++at(other).members_beside, sort_in(other);
  }
  void leave(int node) {
    at(node).is_member = false, --size_;
    at(node).left_at = now_;
    sort_in(node);
    for (const int other : beside(node)) --at(other).members_beside, sort_in(other);
  }

  /// Keeps the lists of who has no member, and who has one, beside it.
  void sort_in(int node) {
    Node& n = at(node);
    if (n.list >= 0) {
      std::vector<int>& old = outside_[static_cast<std::size_t>(n.list)];
      at(old.back()).place = n.place;
      old[n.place] = old.back();
      old.pop_back();
    }
    n.list = n.is_member || n.members_beside > 1 ? -1 : n.members_beside;
    if (n.list < 0) return;
    std::vector<int>& list = outside_[static_cast<std::size_t>(n.list)];
    n.place = list.size();
    list.push_back(node);
  }

  const Graph& graph_;
  std::vector<Node> nodes_;
  std::array<std::vector<int>, 2> outside_;  ///< nodes outside the set, by the number of members beside them
  std::size_t size_ = 0;
  std::int64_t now_ = 0;
  std::mt19937_64 random_;
};

}  // namespace

std::vector<int> find_free_set(const Graph& graph, std::int64_t steps, std::uint64_t seed) {
  if (graph.empty()) return {};
  Search search(graph, seed);
  std::vector<int> largest;
  for (std::int64_t i = 0; i < steps; ++i) {
    search.step();
    if (search.size() > largest.size()) largest = search.members();
  }
  return largest;
}

}  // namespace ninedot::codes
