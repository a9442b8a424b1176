#pragma once
/// Places to start the adjustment from: from landmark to landmark over the pictures that show both.
#include "mapping/sighting_network.h"

namespace ninedot {

/// What all pictures of two landmarks say of the second one's place in the first one's frame.
struct LandmarkLink {
  std::size_t from = 0, to = 0;  ///< indices [1] of landmarks, from < to
  PlaceConsensus in_from;        ///< place of `to`, with `from` for the world
};

/// One for each two landmarks that a picture shows together.
std::vector<LandmarkLink> find_links(const SightingNetwork& network);

/// Places every landmark that is joined to one with a given place, over a tree of links. A link that few pictures agree
/// about, or whose mirror image is as likely, is taken where there is no other; among the rest the most certain come
/// first (Prim's algorithm).
void place_landmarks(SightingNetwork& network, const std::vector<LandmarkLink>& links);

/// Places every frame by the placed landmarks in it: the start that the most of them agree about, then adjusted.
void place_frames(SightingNetwork& network);

/// A landmark's place as the pictures see it that show it beside others, which stay where they are.
/// \param landmark  index [1] \param sightings_of_landmark  indices of all its sightings
/// \return  nothing: there is no such picture
std::optional<PlaceConsensus> place_among_others(const SightingNetwork& network, std::size_t landmark,
                                                 const std::vector<std::size_t>& sightings_of_landmark);

}  // namespace ninedot
