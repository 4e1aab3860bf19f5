#include "transport/render/stages/guide_file.h"

#include <algorithm>
#include <filesystem>

#include "transport/render/stages/checkpoint.h"

namespace raylex::transport {
namespace {

/// The render's identity without what changes no guide, and with the length of the training.
display::RecordIdentity guide_identity(const ResolvedJob& job, std::uint32_t samples, const GuideTraining& training) {
    display::RecordIdentity identity = render_identity(job);
    const auto is_of_image = [&](const auto& field) {
        for (const char* kind : {"crop", "sample", "first sample", "adaptive", "end", "cryptomatte"})
            if (field.first.starts_with(kind)) return true;
        // Beside a beauty of all light, other channels change no path (Law 2).
        return job.channels.takes_all && field.first.starts_with("channel ");
    };
    const auto own = identity.begin() + static_cast<std::ptrdiff_t>(job.settings.identity.size());
    identity.erase(std::remove_if(own, identity.end(), is_of_image), identity.end());
    identity.emplace_back("training", std::to_string(samples) + " samples of each pixel" +
                                          (training.request.mode == GuideMode::automatic ? ", auto" : "") +
                                          (training.seconds > 0 ? ", " + std::to_string(training.seconds) + " s" : ""));
    return identity;
}

Error guide_file_error(Error error, const std::string& file) {
    error.file = file;
    error.message = "cannot use this guide file: " + error.message;
    error.hint = "expected the guide of this render, or a name that does not exist yet";
    return error;
}

Result<TrainedGuide> read_guide(const std::string& path, const display::RecordIdentity& identity) {
    const auto record = display::read_record_file(path);
    if (!record) return guide_file_error(record.error(), path);
    std::string message = "it belongs to another render";
    const std::vector<std::string> differences = display::identity_differences(record->identity, identity);
    for (const std::string& each : differences) message += "\n  " + each;
    if (!differences.empty()) return guide_file_error(error_at({}, message), path);
    const display::RecordSection* section = record->find(guide_section);
    auto guide = section != nullptr ? TrainedGuide::from_record(section->content) : std::nullopt;
    if (!guide) return guide_file_error(error_at({}, "its guide is damaged"), path);
    guide->summary.read = true;
    guide->summary.paths = 0;
    return *std::move(guide);
}

}  // namespace

Result<GuideFile> GuideFile::open(const ResolvedJob& job, const IntegratorContext& context,
                                  const GuideTraining& training) {
    GuideFile file;
    const std::string& path = job.settings.paths.guide_file;
    std::error_code failed;
    const bool exists = !path.empty() && std::filesystem::exists(path, failed);
    const std::uint32_t samples = training_samples(context, training);
    if (job.budget.only && training.seconds > 0 && samples > 0 && !exists)
        return error_at({},
                        "one sample of a render with a time limit needs the guide of that render, whose training the "
                        "clock ended",
                        "expected the 'guide' and 'guidesamples' that the render printed, or its guide file");
    if (path.empty()) return file;
    file.identity_ = guide_identity(job, samples, training);
    if (exists) {
        auto guide = read_guide(path, file.identity_);
        if (!guide) return guide.error();
        file.guide = *std::move(guide);
    } else if (!job.budget.only) {  // one replayed sample writes no file
        if (Status writable = display::check_writable(path); !writable) return writable.error();
        file.unwritten_ = path;
    }
    return file;
}

void GuideFile::write(TrainedGuide& trained, std::vector<Error>& warnings) const {
    if (unwritten_.empty()) return;
    const GuideSummary summary = trained.summary;
    trained.summary.seconds = trained.summary.cpu_seconds = 0;  // the same bytes from every writer
    display::RecordFile record{identity_, {{guide_section, trained.record()}}};
    trained.summary = summary;
    if (const Status written = display::write_record_file(unwritten_, record); !written)
        warnings.push_back(written.error());
}

}  // namespace raylex::transport
