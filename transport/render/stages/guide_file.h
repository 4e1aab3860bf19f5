// A file with a trained guide, which the shards of a render share, so that one of them trains for all. Private to
// transport/render.
//
// The file is a record (display/checkpoint/record_file.h) with one section, "guide". Its identity has everything that
// the guide depends on, so all shards and crops of a render share it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "transport/render/pilots/guide_pilot.h"
#include "transport/render/resolve/resolved_job.h"

namespace raylex::transport {

class GuideFile {
  public:
    /// Reads the job's PathSettings::guide_file, if there is one. If it does not exist, checks that it can be written.
    /// Errors name the file: it cannot be read or written, it is damaged, it has the guide of another render (with all
    /// differences). Without the file, one sample of a render whose training the clock ends is an Error, too.
    static Result<GuideFile> open(const ResolvedJob& job, const IntegratorContext& context,
                                  const GuideTraining& training);

    /// Writes the guide, unless the file existed. All renders that share the file write the same bytes. A failure is a
    /// warning, because the render has its guide.
    void write(TrainedGuide& trained, std::vector<Error>& warnings) const;

    std::optional<TrainedGuide> guide;  ///< from the file; nothing if it does not exist

  private:
    std::string unwritten_;  ///< the file to write; empty: none
    display::RecordIdentity identity_;
};

}  // namespace raylex::transport
