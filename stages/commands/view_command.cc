// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/view_command.h"

#include <chrono>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <memory>
#include <spawn.h>
#include <thread>
#include <unistd.h>
#include <utility>

#include "pipeline/option_table.h"
#include "stages/registry/pipeline_options.h"
#include "stages/run/workspace_folder.h"
#include "stages/view/access.h"
#include "stages/view/scene_cache.h"
#include "stages/view/view_api.h"
#include "stages/view/view_server.h"
#include "stages/viewer/web_bundle.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

// Shows an address in the browser; what that prints goes nowhere.
Status OpenBrowser(const std::string& address) {
  std::string program = "xdg-open";
  std::string argument = address;
  char* const words[] = {program.data(), argument.data(), nullptr};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    posix_spawn_file_actions_addopen(&actions, stream, "/dev/null", O_RDWR, 0);
  }
  pid_t child = 0;
  const int error =
      posix_spawnp(&child, words[0], &actions, nullptr, words, environ);
  posix_spawn_file_actions_destroy(&actions);
  return error == 0 ? Status()
                    : MissingDependencyError(std::string("xdg-open: ") +
                                             std::strerror(error));
}

struct ViewRequest {
  PipelineOptions options;
  ViewServerOptions server;
  bool open = false;
};

CommandWords DescribeView(ViewRequest* request) {
  pipeline::OptionTable table = MakeOptionTable(&request->options);
  table.LimitCommandLine({"general.threads", "query"});
  CommandWords words("view",
                     "Shows the scene, and a run under way, in the browser.",
                     std::move(table));
  words.AddArgument(WorkspaceArgument());
  words.AddOption("port",
                  &request->server.port,
                  {.help = "Port of the page; 0 takes any free one. Without "
                           "the option the next free one is taken when this "
                           "is not.",
                   .min = 0,
                   .max = 65535});
  words.AddOption("host",
                  &request->server.address,
                  {.help = "Address to listen at. Others than this machine's "
                           "own can be reached from the network, with a "
                           "token.",
                   .value_name = "ADDRESS"});
  words.AddOption("open",
                  &request->open,
                  {.help = "Show the page in the browser of the desktop."});
  words.AddNote("Ctrl-C ends it.");
  return words;
}

// Reads the command line and the workspace's options.
Status ParseViewRequest(const std::vector<std::string>& arguments,
                        ViewRequest* request,
                        ViewApiOptions* api) {
  CommandWords words = DescribeView(request);
  FREEGS_ASSIGN_OR_RETURN(const pipeline::OptionTable::CommandLine line,
                          words.Parse(arguments));
  FREEGS_ASSIGN_OR_RETURN(api->workspace,
                          ExistingWorkspace(line.positional[0]));
  FREEGS_RETURN_IF_ERROR(CheckWorkspaceFolder(api->workspace));
  FREEGS_RETURN_IF_ERROR(
      ApplyQuerySettings(api->workspace, line.settings, words.table()));
  for (const pipeline::OptionSetting& setting : line.settings) {
    if (setting.name == "port") request->server.more_ports = 0;
  }
  api->query_defaults.text_options = request->options.query;
  api->query_defaults.threads = request->options.general.threads;
  return Status();
}

}  // namespace

CommandWords ViewWords() { return KeepWords<ViewRequest>(DescribeView); }

Status RunViewCommand(const std::vector<std::string>& arguments,
                      CommandContext& context) {
  ViewRequest request;
  ViewApiOptions options;
  FREEGS_RETURN_IF_ERROR(ParseViewRequest(arguments, &request, &options));
  AccessRules rules;
  rules.address = request.server.address;
  FREEGS_ASSIGN_OR_RETURN(request.server.address,
                          NumericAddress(rules.address));
  if (IsNumericAddress(rules.address)) rules.address = request.server.address;
  if (!IsLoopback(rules.address)) {
    FREEGS_ASSIGN_OR_RETURN(rules.token, MakeToken());
    rules.host_name = HostName();
  }
  const StatusOr<fs::path> web = FindWebBundle();
  if (web.ok()) {
    options.web = *web;
    options.make_scene = MakeSceneParts;
  }

  FREEGS_ASSIGN_OR_RETURN(const std::unique_ptr<ViewServer> server,
                          ViewServer::Bind(request.server));
  rules.port = server->port();
  ViewApi api(options, rules);
  server->Start(&api);
  const std::vector<std::string> addresses = ViewAddresses(rules);
  for (const std::string& address : addresses) {
    context.out << "view: " << address << std::endl;
  }
  if (request.open) {
    const Status opened = OpenBrowser(addresses[0]);
    if (!opened.ok()) {
      context.err << "view: cannot open a browser (" << opened.message()
                  << "); open the address yourself\n";
    }
  }
  while (!context.cancellation.cancelled()) {
    if (!server->running()) {
      return InternalError(
          "the system takes no more connections for this server; start "
          "freegs_pipeline view again");
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  server->Stop();
  return Status();
}

}  // namespace freegs::stages
