// SPDX-License-Identifier: BSD-3-Clause
// The few things we ask of COLMAP's SQLite database beside what its own
// commands do: which photos are in it, and moving matches between two copies.

#ifndef FREEGS_SFM_MATCHING_MATCH_DATABASE_H_
#define FREEGS_SFM_MATCHING_MATCH_DATABASE_H_

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "core/status.h"
#include "sfm/matching/descriptor_matching.h"

struct sqlite3;

namespace freegs::sfm {

// Feature feature1 of one image shows what feature2 of another shows.
struct FeatureMatch {
  uint32_t feature1 = 0;
  uint32_t feature2 = 0;
};

class MatchDatabase {
 public:
  struct Photo {
    uint32_t id = 0;
    std::string name;
    int64_t num_features = 0;
  };

  // Opens an existing database that COLMAP wrote.
  static StatusOr<MatchDatabase> Open(const std::filesystem::path& path);

  // Photos by ascending id.
  StatusOr<std::vector<Photo>> Photos() const;

  // The SIFT descriptors of a photo; empty when it has none. kBadInput when
  // they are of another kind.
  StatusOr<SiftDescriptors> Descriptors(uint32_t photo_id) const;

  // The size of each feature of a photo in its image; empty when it has none,
  // or the database does not say. Never NaN.
  StatusOr<std::vector<float>> FeatureScales(uint32_t photo_id) const;

  // A pair of photos with verified matches, and the motion that fits them.
  struct VerifiedPair {
    uint32_t id1 = 0;  // Smaller than id2.
    uint32_t id2 = 0;
    int64_t num_matches = 0;

    // Whether a homography explains the matches as well as any motion: a plane
    // was seen, or the camera only turned. homography maps pixels of id1 to
    // pixels of id2; it may be missing.
    bool is_homography = false;
    std::optional<Eigen::Matrix3d> homography;
  };

  // By ascending ids. Databases without such details give pairs without them.
  StatusOr<std::vector<VerifiedPair>> VerifiedPairs() const;

  // Calls visit(id1, id2, matches) for each pair of photos with verified
  // matches, by ascending ids; id1 < id2.
  Status ForEachVerifiedPair(
      const std::function<void(
          uint32_t, uint32_t, std::span<const FeatureMatch>)>& visit) const;

  // Deletes the verified matches of pairs of photos; of all.
  Status RemoveVerifiedPairs(
      const std::vector<std::pair<uint32_t, uint32_t>>& pairs);
  Status ClearVerified();

  // Copies all raw and verified matches of the database at `other`, which
  // holds the same photos under the same ids, into this one, in one
  // transaction. Those already here are replaced.
  Status CopyMatchesFrom(const std::filesystem::path& other);

  // Copies this database as it is now into a new file.
  Status CopyTo(const std::filesystem::path& path) const;

  // Gives every photo another name.
  Status RenamePhotos(const std::function<std::string(uint32_t id)>& name);

  // Deletes what describes features and which match; photos, cameras and
  // keypoints stay.
  Status ClearMatchesAndDescriptors();

 private:
  struct Closer {
    void operator()(sqlite3* database) const;
  };
  Status Execute(const std::string& sql) const;
  bool HasColumn(const char* table, const char* column) const;
  Status Error(const std::string& what) const;

  std::filesystem::path path_;
  std::unique_ptr<sqlite3, Closer> database_;
};

// Copies a database into a new file; one that is there is replaced.
Status CopyDatabase(const std::filesystem::path& from,
                    const std::filesystem::path& to);

// As MatchDatabase::RemoveVerifiedPairs.
Status RemoveVerifiedPairs(
    const std::filesystem::path& path,
    const std::vector<std::pair<uint32_t, uint32_t>>& pairs);

// Deletes a database file and what SQLite keeps beside it, if there.
void RemoveDatabase(const std::filesystem::path& path);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MATCHING_MATCH_DATABASE_H_
