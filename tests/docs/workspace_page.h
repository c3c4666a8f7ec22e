// SPDX-License-Identifier: BSD-3-Clause
// docs/workspace.md beside a workspace: what one has and the other has not.

#ifndef FREEGS_TESTS_DOCS_WORKSPACE_PAGE_H_
#define FREEGS_TESTS_DOCS_WORKSPACE_PAGE_H_

#include <filesystem>
#include <map>
#include <set>
#include <string>

namespace freegs::docs {

// The page names files in the first column of tables, and the fields of a JSON
// file below a heading that is the file's name: in the first column of a table
// those that the other way round have to be in the file.
class WorkspacePage {
 public:
  explicit WorkspacePage(const std::filesystem::path& page);

  // Looks at all files of a workspace, and notes what was found. Adds what the
  // page does not name to unnamed(). Names of photos, by which files list what
  // is known of each, are no fields.
  void Compare(const std::filesystem::path& workspace);

  // Files, "FILE: FIELD" and "FILE: COLUMN".
  const std::set<std::string>& unnamed() const { return unnamed_; }

  // What the page names and no workspace had, in the same form.
  std::set<std::string> Missing() const;

 private:
  struct Section {
    std::set<std::string> named;  // Everything between ` and `.
    std::set<std::string> rows;  // Those of them that begin the rows of tables.
  };

  // The pattern of a file, or an empty text.
  std::string PatternOf(const std::string& file) const;

  std::map<std::string, std::string> patterns_;  // And each as an expression.
  std::map<std::string, Section> sections_;      // By pattern.
  std::set<std::string> code_;                   // All code of the page.
  std::set<std::string> found_;
  std::set<std::string> unnamed_;
};

}  // namespace freegs::docs

#endif  // FREEGS_TESTS_DOCS_WORKSPACE_PAGE_H_
