// SPDX-License-Identifier: Apache-2.0
#include "live/packer.hpp"

#include <tbb/task_arena.h>

#include <new>
#include <utility>

#include "core/process.hpp"
#include "splinevox/run/evaluate.hpp"

namespace splinevox::run {
namespace {

std::string packed(const VoxelModel& model, ViewPage page, std::int64_t step) {
  page.full_flow = kFullFlow * model.box.longest_edge();
  ViewQuality quality = view_qualities().front();
  quality.everywhere = true;
  const PackedScene scene = pack_scene(model, quality);
  Json about = view_header(page, scene);
  about["step_of_training"] = step;
  const std::string header = json_text(about);
  std::string out;
  for (int shift = 0; shift < 32; shift += 8) out += char(header.size() >> shift & 0xff);
  out += header;
  out.append(reinterpret_cast<const char*>(scene.bytes.data()), scene.bytes.size());
  return out;
}

}  // namespace

ModelPacker::ModelPacker() : thread_([this] { work(); }) {}

ModelPacker::~ModelPacker() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

bool ModelPacker::idle() const {
  const std::lock_guard lock(mutex_);
  return !busy_;
}

void ModelPacker::take(VoxelModel model, const ViewPage& page, std::int64_t step) {
  {
    const std::lock_guard lock(mutex_);
    job_ = Job{std::move(model), page, step};
    busy_ = true;
  }
  changed_.notify_all();
}

LiveModel ModelPacker::latest() const {
  const std::lock_guard lock(mutex_);
  return latest_;
}

double ModelPacker::spent() const {
  const std::lock_guard lock(mutex_);
  return spent_;
}

double ModelPacker::last() const {
  const std::lock_guard lock(mutex_);
  return last_;
}

void ModelPacker::work() {
  tbb::task_arena alone(1);  // training has the others, and this thread's time is what it costs
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [&] { return closing_ || job_; });
    if (closing_) return;
    const Job job = std::move(*job_);
    job_.reset();
    lock.unlock();
    const double start = thread_seconds();
    std::shared_ptr<const std::string> bytes;
    try {
      alone.execute(
          [&] { bytes = std::make_shared<const std::string>(packed(job.model, job.page, job.step)); });
    } catch (const std::bad_alloc&) {  // the page goes without it: training is what memory is for
    }
    const double took = thread_seconds() - start;
    lock.lock();
    if (bytes) latest_ = {std::move(bytes), job.step};
    last_ = took;
    spent_ += took;
    busy_ = false;
  }
}

}  // namespace splinevox::run
