#include "tests/bench/trust/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <mutex>
#include <thread>

#include "drivers/picture/picture_file.h"
#include "tests/bench/trust/csv.h"

namespace ninedot::bench {
namespace {

std::string file_name_of(const Strip& strip, std::size_t frame) {
  std::string name = fmt::format("{}--{}--{}.png", strip.kind, strip.name, frame);
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && std::string_view("-+@._").find(c) == std::string_view::npos)
      c = '_';
  return name;
}

// Takes what all threads find; sums and lines are kept per job, for the order in which jobs end is anybody's guess.
class Collector {
 public:
  Collector(std::size_t jobs, const RunOptions& options)
      : options_(options), tallies_(jobs), lines_(jobs), done_(jobs) {
    if (!options_.save.empty()) std::filesystem::create_directories(options_.save);
  }

  void take(std::size_t job, const Strip& strip) {
    const std::vector<Verdict> verdicts = judge(strip, options_.camera);
    for (std::size_t frame = 0; frame < verdicts.size(); ++frame) {
      const Verdict& v = verdicts[frame];
      tallies_[job][strip.kind].add(v);
      pictures_ += 1, wrong_ += v.wrong ? 1 : 0;
      if (options_.csv != nullptr) lines_[job] += csv_line(strip, frame, v);
      if (options_.save.empty()) continue;
      if (options_.slowest > 0)
        keep_if_slow(v.work_ms, strip, frame);
      else if (v.wrong || options_.save_all)
        save(file_name_of(strip, frame), strip.shots[frame].picture);
    }
  }

  void end_job(std::size_t job) {
    const std::scoped_lock lock(mutex_);
    done_[job] = true, ++count_done_;
    // In order, and as early as that allows: a run that is stopped has left what it knew.
    for (; next_line_ < done_.size() && done_[next_line_]; ++next_line_) {
      if (options_.csv != nullptr) fmt::print(options_.csv, "{}", lines_[next_line_]);
      lines_[next_line_].clear();
    }
    if (options_.progress)
      fmt::print(stderr, "\r{} of {} jobs, {} pictures, {} wrong and valid", count_done_, done_.size(),
                 pictures_.load(), wrong_.load());
  }

  Tallies result() const {
    for (const Slow& slow : slowest_) save(slow.file_name, slow.picture);
    Tallies all;
    for (const Tallies& of_job : tallies_)
      for (const auto& [kind, tally] : of_job) all[kind].add(tally);
    if (options_.progress) fmt::print(stderr, "\n");
    return all;
  }

 private:
  struct Slow {
    double work_ms;
    std::string file_name;
    test::Picture picture;
  };

  void keep_if_slow(double work_ms, const Strip& strip, std::size_t frame) {
    const std::scoped_lock lock(mutex_);
    const auto place =
        std::find_if(slowest_.begin(), slowest_.end(), [=](const Slow& s) { return s.work_ms < work_ms; });
    if (place == slowest_.end() && slowest_.size() >= options_.slowest) return;
    slowest_.insert(place, {work_ms, file_name_of(strip, frame), strip.shots[frame].picture});
    if (slowest_.size() > options_.slowest) slowest_.pop_back();
  }

  void save(const std::string& file_name, const test::Picture& picture) const {
    const std::string path = (options_.save / file_name).string();
    if (!write_png_grey(path, picture.view())) fmt::print(stderr, "trust: cannot write {}\n", path);
  }

  const RunOptions& options_;
  std::vector<Tallies> tallies_;
  std::vector<std::string> lines_;
  std::atomic<std::size_t> pictures_{0}, wrong_{0};
  std::mutex mutex_;  // of what follows
  std::vector<bool> done_;
  std::size_t count_done_ = 0, next_line_ = 0;
  std::vector<Slow> slowest_;  // the slowest first
};

}  // namespace

Tallies run_jobs(const std::vector<Job>& jobs, const RunOptions& options) {
  Collector collector(jobs.size(), options);
  std::atomic<std::size_t> next{0};
  std::vector<std::jthread> workers;
  for (unsigned t = 0; t < options.threads; ++t)
    workers.emplace_back([&] {
      for (std::size_t job = next++; job < jobs.size(); job = next++) {
        jobs[job]([&](const Strip& strip) { collector.take(job, strip); });
        collector.end_job(job);
      }
    });
  workers.clear();
  return collector.result();
}

double usual_work_ms() {
  std::vector<double> work_ms;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    test::Scene scene;
    scene.camera =
        test::look_at_landmark({.distance_m = 1.5, .tilt_rad = 0.4, .azimuth_rad = 0.7 * static_cast<double>(seed)});
    scene.wall.seed = seed;
    test::set_noise(scene.sensor, 2);
    Strip strip;
    strip.shots.push_back({test::render(scene, seed), scene.camera, 0, {}});
    work_ms.push_back(judge(strip).front().work_ms);
  }
  std::sort(work_ms.begin(), work_ms.end());
  return work_ms[work_ms.size() / 2];
}

}  // namespace ninedot::bench
