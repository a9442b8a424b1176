#pragma once
/// Which landmarks of the map no longer hang where it says, and of which nobody knows.
#include <cstdint>
#include <vector>

namespace ninedot {

/// A landmark that the others have named as moved is not believed again until it has agreed with them for a while;
/// above all it is not believed when it is seen alone, where nothing would contradict it.
/// Two that contradict each other, with nothing that decides, are both in dispute: one of them was moved. Each stays so
/// until it has agreed with others, or with a track, for a while, or another one has been named.
/// Landmarks are named by their index [1].
/// Memory: four bytes for each landmark, at construction. Threads: one caller.
class MovedLandmarks {
 public:
  /// One second at 35 frames per second: a sheet that is hung back is believed soon, and one that leans into its place
  /// for a moment is not. Chosen, not measured.
  static constexpr int kForgivenAfter_frames = 35;
  /// Of one in dispute nobody has said that it was moved: it needs less. Chosen, not measured.
  static constexpr int kSettledAfter_frames = 10;

  /// \param landmarks  of the map \param forgiven_after_frames  >= 1 (contract)
  explicit MovedLandmarks(std::size_t landmarks, int forgiven_after_frames = kForgivenAfter_frames);

  /// \param landmark  index into the map's landmarks (contract)
  bool is_moved(std::size_t landmark) const noexcept;
  /// The others say that it is not in its place, in a frame that leaves no doubt of it. \param landmark  index
  /// \param beyond_chi2  by how much it disagrees more than chance does: as many frames have to agree before it is
  /// forgiven, up to the most. Of ten thousand true ones one is above chance, and by little. [1]
  void disagrees(std::size_t landmark, double beyond_chi2) noexcept;
  /// The others say that it is in its place. \param landmark  index
  void agrees(std::size_t landmark) noexcept;

  /// \param landmark  index (contract)
  bool is_disputed(std::size_t landmark) const noexcept;
  std::size_t disputed() const noexcept;  ///< how many are [1]
  /// It and another one contradict each other. \param landmark  index \param beyond_chi2  as of disagrees() [1]
  void dispute(std::size_t landmark, double beyond_chi2) noexcept;
  /// What is known of a landmark of another map that hangs unchanged in this one. \param before  the other map's
  /// \param landmark_before, landmark  index there and here [1]
  void carry_over(const MovedLandmarks& before, std::size_t landmark_before, std::size_t landmark) noexcept;
  /// Forgets all: the map is another one, or someone has looked.
  void clear() noexcept;

 private:
  std::vector<std::uint16_t> to_agree_frames_;  // until it is forgiven; 0: it is believed
  std::vector<std::uint16_t> disputed_frames_;  // likewise, until it is out of dispute
  std::uint16_t forgiven_after_frames_;
};

}  // namespace ninedot
