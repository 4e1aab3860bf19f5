// What one render is asked to do: the sum of a job file and the command line.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "display/services/parameters.h"
#include "experiments/job/output_requests.h"
#include "lpe/channels/channel_file.h"
#include "lpe/event.h"
#include "lpe/language/names.h"
#include "transport/render/render.h"
#include "transport/scene/effects/effects.h"
#include "transport/scene/missing_files.h"
#include "transport/scene/scene_description.h"

namespace raylex::experiments {

/// One light path expression channel, as --lpe or a [[channel]] table gives it.
struct ExpressionRequest {
    std::string name;
    std::string expression;
    lpe::Dialect dialect = lpe::Dialect::renderman;
    SourceLocation location;                      ///< of the expression's first character, for errors
    std::shared_ptr<const lpe::SourceMap> map{};  ///< where each of its characters stands, when a file says so
};

/// A geometric AOV by its standard name.
struct AovRequest {
    std::string name;
    SourceLocation location;
};

/// A partition that the job declares; proved before a ray is traced.
struct PartitionRequest {
    std::string name;
    std::string of;  ///< channel that is split; empty = beauty
    std::vector<std::string> channels;
    std::string rest;  ///< not empty: a layer of this name takes what the channels leave
    SourceLocation location;
};

/// Layers by sampling technique, as --techniques and `techniques` in [channels] ask for them.
struct TechniqueRequest {
    std::vector<std::string> channels;  ///< "beauty", or channels of the job
    SourceLocation location;
};
/// "pyramid" (of beauty), or "pyramid:" and names of channels between commas.
Result<TechniqueRequest> parse_techniques(const std::string& text, const SourceLocation& where);

/// A render of some of the image's samples, whose sums are a file for `raylex merge`.
struct ShardRequest {
    unsigned part = 1, parts = 1;  ///< the part-th of so many, counted from 1
    std::string record;            ///< where its sums go
};

/// A plugin that the job file names.
struct PluginRequest {
    std::string file;
    SourceLocation location;
};

struct Job {
    std::string scene_file;
    std::string job_file, job_text;  ///< the TOML this came from; empty for a bare scene
    std::string output, preview, statistics;
    std::string ocio_config, rendering_space, display, view;
    double exposure = 0;                  ///< stops by which previews show light brighter
    double checkpoint_seconds = 0;        ///< between checkpoints; 0 = none
    bool resume = false;                  ///< go on from the checkpoint beside the output
    std::optional<ShardRequest> shard{};  ///< instead of the image
    transport::MissingFiles missing = transport::MissingFiles::refused;  ///< files that the scene names
    bool texture_rules = false;  ///< colours of image textures by the colour config's file rules, not pbrt's
    OutputRequests outputs;
    bool shipped_partition = false;  ///< adds the shipped partition's channels
    bool light_groups = false;       ///< adds one layer per light group and one for the unlabelled lights
    std::optional<TechniqueRequest> techniques;
    transport::RenderSettings settings;  ///< `channels.list` is filled by plan_channels()
    transport::EffectChoices effects;    ///< applied by load_job_scene()
    bool show_effects = false;           ///< all of them are printed, with why
    std::vector<ExpressionRequest> expressions;
    std::vector<AovRequest> aovs;
    std::vector<display::ChannelDefinition> declared;  ///< plain channels that plugins write to
    std::vector<PluginRequest> plugins;                ///< loaded by read_job()
    std::vector<PartitionRequest> partitions;
    bool measure_refuted = false;               ///< partitions that are none are noted and measured, not refused
    lpe::MacroTable macros;                     ///< names that the job's expressions may use
    std::vector<lpe::LobeOption> lobe_options;  ///< as given; settings.labels.lobe_slots holds what they make
    std::vector<transport::LabelRule> label_rules;
};

/// "renderman" or "osl"; anything else is an Error at `where` that says so.
Result<lpe::Dialect> parse_dialect(const std::string& name, const SourceLocation& where);
/// "osl:C.*" and "renderman:C.*" say their own dialect: the mark is taken off. Neither dialect has such a beginning in
/// its language.
void take_dialect_mark(std::string& expression, lpe::Dialect& dialect);

/// "WxH" with both between 1 and 65536.
Result<std::array<int, 2>> parse_resolution(const std::string& text, const SourceLocation& where);

/// "error" or "placeholder".
Result<transport::MissingFiles> parse_missing(const std::string& text, const SourceLocation& where);
/// "X0,Y0,X1,Y1", whole numbers from 0 on with X0 < X1 and Y0 < Y1.
Result<display::PixelRegion> parse_crop(const std::string& text, const SourceLocation& where);

/// Adds a kind of cryptomatte by name; an unknown one, or one that is there already, is an Error at `where`.
Status add_cryptomatte(const std::string& name, const SourceLocation& where, transport::MatteSettings& mattes);

/// A further output of a channel, as --layer and [[layer]] ask for it. Errors at `where`: a name that cannot be a
/// layer's, no such rule.
Result<display::LayerRequest> read_layer_request(const std::string& name, const std::string& channel,
                                                 const std::string& rule, const SourceLocation& where);

/// Names that can be a layer: letters, digits and _ - . : in any order, beginning with a letter or _; at most 128
/// bytes. The names of the beauty (beauty, rgba, R, G, B, A, Y) are taken, and those of cryptomattes (CryptoObject...).
Status check_layer_name(const std::string& name, const SourceLocation& where);

}  // namespace raylex::experiments
