// SPDX-License-Identifier: BSD-3-Clause
// COLMAP's SQLite database.

#include "sfm/matching/match_database.h"

#include <algorithm>
#include <cmath>
#include <sqlite3.h>
#include <string_view>
#include <system_error>
#include <tuple>

#include "core/io/byte_stream.h"

namespace freegs::sfm {
namespace {

// COLMAP's id of a pair of images: smaller id times this, plus larger id.
constexpr int64_t kMaxImageId = 2147483647;

// COLMAP's TwoViewGeometry::ConfigurationType of motions that are homographies:
// PLANAR, PANORAMIC, PLANAR_OR_PANORAMIC.
constexpr int64_t kFirstHomography = 4;
constexpr int64_t kLastHomography = 6;

// COLMAP's number of SIFT among the kinds of descriptors, in releases that know
// several.
constexpr int64_t kSiftType = 0;

class Statement {
 public:
  Statement(sqlite3* database, const char* sql) {
    result_ = sqlite3_prepare_v2(database, sql, -1, &statement_, nullptr);
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  bool ok() const { return result_ == SQLITE_OK; }
  void Bind(int index, const std::string& text) {
    sqlite3_bind_text(statement_, index, text.c_str(), -1, SQLITE_TRANSIENT);
  }
  // `bytes` must outlive the call of Step().
  void BindBlob(int index, std::string_view bytes) {
    sqlite3_bind_blob64(
        statement_, index, bytes.data(), bytes.size(), SQLITE_STATIC);
  }
  void Bind(int index, int64_t value) {
    sqlite3_bind_int64(statement_, index, value);
  }
  // SQLITE_ROW, SQLITE_DONE or an error.
  int Step() { return sqlite3_step(statement_); }
  int64_t Integer(int column) const {
    return sqlite3_column_int64(statement_, column);
  }
  // A text or blob.
  std::string Text(int column) const {
    const void* data = sqlite3_column_blob(statement_, column);
    const int size = sqlite3_column_bytes(statement_, column);
    return data == nullptr ? std::string()
                           : std::string(static_cast<const char*>(data), size);
  }

 private:
  sqlite3_stmt* statement_ = nullptr;
  int result_;
};

// A 3 x 3 matrix, row by row; nothing unless `data` is one of finite numbers.
std::optional<Eigen::Matrix3d> ParseMatrix(const std::string& data) {
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> matrix;
  ByteReader reader(data);
  if (!reader.GetArray(9, matrix.data()) || !reader.at_end() ||
      !matrix.allFinite()) {
    return std::nullopt;
  }
  return matrix;
}

}  // namespace

StatusOr<std::pair<uint32_t, uint32_t>> MatchDatabase::IdsOf(
    int64_t pair) const {
  const int64_t id1 = pair / kMaxImageId;
  const int64_t id2 = pair % kMaxImageId;
  if (id1 < 1 || id1 >= id2) {
    return BadInputError(path_.string() + ": " + std::to_string(pair) +
                         " is not the number of a pair of photos; the database "
                         "is damaged");
  }
  return std::make_pair(static_cast<uint32_t>(id1), static_cast<uint32_t>(id2));
}

void MatchDatabase::Closer::operator()(sqlite3* database) const {
  sqlite3_close(database);
}

StatusOr<MatchDatabase> MatchDatabase::Open(const std::filesystem::path& path) {
  MatchDatabase result;
  result.path_ = path;
  sqlite3* database = nullptr;
  const int code =
      sqlite3_open_v2(path.c_str(), &database, SQLITE_OPEN_READWRITE, nullptr);
  result.database_.reset(database);
  if (code != SQLITE_OK) return result.Error("cannot be opened");
  sqlite3_busy_timeout(database, 10000);
  // Does not wait for the disk at every change, but keeps the order of writes.
  // So a loss of power does not tear what a step before left there.
  FREEGS_RETURN_IF_ERROR(result.Execute("PRAGMA synchronous = NORMAL"));
  // Makes SQLite look at the file, and finish what a killed writer left.
  Statement probe(database, "SELECT COUNT(*) FROM images");
  if (!probe.ok() || probe.Step() != SQLITE_ROW) {
    return result.Error("is not a COLMAP database");
  }
  return result;
}

Status MatchDatabase::Error(const std::string& what) const {
  const std::string message =
      path_.string() + ": " + what + " (" +
      (database_ ? sqlite3_errmsg(database_.get()) : "out of memory") + ")";
  // A full disk or a lack of memory says nothing about the file.
  switch (database_ ? sqlite3_errcode(database_.get()) & 0xff : SQLITE_NOMEM) {
    case SQLITE_FULL:
    case SQLITE_IOERR:
    case SQLITE_NOMEM:
    case SQLITE_READONLY:
    case SQLITE_BUSY:
      return InternalError(message);
    default:
      return BadInputError(message);
  }
}

Status MatchDatabase::Execute(const std::string& sql) const {
  if (sqlite3_exec(database_.get(), sql.c_str(), nullptr, nullptr, nullptr) !=
      SQLITE_OK) {
    return Error("'" + sql + "' failed");
  }
  return {};
}

StatusOr<std::vector<MatchDatabase::Photo>> MatchDatabase::Photos() const {
  Statement statement(
      database_.get(),
      "SELECT images.image_id, images.name, IFNULL(keypoints.rows, 0) "
      "FROM images LEFT JOIN keypoints "
      "ON keypoints.image_id = images.image_id ORDER BY images.image_id");
  if (!statement.ok()) return Error("cannot list its photos");
  std::vector<Photo> photos;
  int code;
  while ((code = statement.Step()) == SQLITE_ROW) {
    photos.push_back({static_cast<uint32_t>(statement.Integer(0)),
                      statement.Text(1),
                      statement.Integer(2)});
  }
  if (code != SQLITE_DONE) return Error("cannot list its photos");
  return photos;
}

StatusOr<std::map<std::string, uint32_t>> MatchDatabase::PhotoIds() const {
  FREEGS_ASSIGN_OR_RETURN(const std::vector<Photo> photos, Photos());
  std::map<std::string, uint32_t> ids;
  for (const Photo& photo : photos) ids[photo.name] = photo.id;
  return ids;
}

StatusOr<std::map<std::string, uint32_t>> MatchDatabase::CameraIds() const {
  Statement statement(database_.get(), "SELECT name, camera_id FROM images");
  if (!statement.ok()) return Error("cannot list its cameras");
  std::map<std::string, uint32_t> ids;
  int code;
  while ((code = statement.Step()) == SQLITE_ROW) {
    ids[statement.Text(0)] = static_cast<uint32_t>(statement.Integer(1));
  }
  if (code != SQLITE_DONE) return Error("cannot list its cameras");
  return ids;
}

StatusOr<SiftDescriptors> MatchDatabase::Descriptors(uint32_t photo_id) const {
  Statement statement(
      database_.get(),
      "SELECT rows, cols, data FROM descriptors WHERE image_id = ?");
  if (!statement.ok()) return Error("cannot read its descriptors");
  statement.Bind(1, photo_id);
  SiftDescriptors descriptors;
  const int code = statement.Step();
  if (code == SQLITE_DONE) return descriptors;
  if (code != SQLITE_ROW) return Error("cannot read its descriptors");
  const int64_t rows = statement.Integer(0);
  const std::string data = statement.Text(2);
  if (rows == 0) return descriptors;
  constexpr int64_t kColumns = kSiftDimensions;
  if (statement.Integer(1) != kColumns || rows < 0 ||
      data.size() % kSiftDimensions != 0 ||
      static_cast<int64_t>(data.size() / kSiftDimensions) != rows) {
    return BadInputError(path_.string() + ": the descriptors of photo " +
                         std::to_string(photo_id) +
                         " are not 128 bytes each, as SIFT's");
  }
  descriptors.values.assign(data.begin(), data.end());
  return descriptors;
}

StatusOr<MatchDatabase::KeypointTable> MatchDatabase::ReadKeypoints(
    uint32_t photo_id) const {
  Statement statement(
      database_.get(),
      "SELECT rows, cols, data FROM keypoints WHERE image_id = ?");
  if (!statement.ok()) return Error("cannot read its keypoints");
  statement.Bind(1, photo_id);
  KeypointTable table;
  const int code = statement.Step();
  if (code == SQLITE_DONE) return table;
  if (code != SQLITE_ROW) return Error("cannot read its keypoints");
  const int64_t rows = statement.Integer(0);
  const int64_t columns = statement.Integer(1);
  const std::string data = statement.Text(2);
  if (columns != 2 && columns != 4 && columns != 6) return table;
  table.columns = static_cast<size_t>(columns);
  const size_t row_bytes = table.columns * sizeof(float);
  if (rows < 0 || data.size() % row_bytes != 0 ||
      static_cast<int64_t>(data.size() / row_bytes) != rows) {
    return BadInputError(path_.string() + ": the keypoints of photo " +
                         std::to_string(photo_id) + " are not of their size");
  }
  table.values.resize(data.size() / sizeof(float));
  ByteReader reader(data);
  reader.GetArray(table.values.size(), table.values.data());
  return table;
}

StatusOr<std::vector<float>> MatchDatabase::FeatureScales(
    uint32_t photo_id) const {
  FREEGS_ASSIGN_OR_RETURN(const KeypointTable table, ReadKeypoints(photo_id));
  std::vector<float> scales;
  if (table.columns == 2) return scales;
  for (size_t i = 0; i < table.values.size(); i += table.columns) {
    const float* v = &table.values[i];
    const float scale =
        table.columns == 4
            ? v[2]
            : 0.5f * (std::hypot(v[2], v[4]) + std::hypot(v[3], v[5]));
    scales.push_back(std::isfinite(scale) ? scale : 0.0f);
  }
  return scales;
}

StatusOr<std::vector<Eigen::Vector2f>> MatchDatabase::FeaturePositions(
    uint32_t photo_id) const {
  FREEGS_ASSIGN_OR_RETURN(const KeypointTable table, ReadKeypoints(photo_id));
  std::vector<Eigen::Vector2f> positions;
  for (size_t i = 0; i < table.values.size(); i += table.columns) {
    const Eigen::Vector2f position(table.values[i], table.values[i + 1]);
    positions.push_back(position.allFinite() ? position
                                             : Eigen::Vector2f::Zero());
  }
  return positions;
}

Status MatchDatabase::SetCameras(std::span<const PhotoCamera> cameras) {
  FREEGS_RETURN_IF_ERROR(Execute("BEGIN IMMEDIATE"));
  for (const PhotoCamera& camera : cameras) {
    Statement statement(database_.get(),
                        "UPDATE cameras SET width = ?, height = ?, params = ?, "
                        "prior_focal_length = ?, model = ? WHERE camera_id = "
                        "(SELECT camera_id FROM images WHERE image_id = ?)");
    if (!statement.ok()) return Error("cannot take cameras");
    ByteWriter params;
    for (const double value : camera.params) params.Put(value);
    statement.Bind(1, static_cast<int64_t>(camera.width));
    statement.Bind(2, static_cast<int64_t>(camera.height));
    statement.BindBlob(3, params.content());
    statement.Bind(4, static_cast<int64_t>(camera.focal_known));
    statement.Bind(5, static_cast<int64_t>(camera.model));
    statement.Bind(6, camera.photo_id);
    if (statement.Step() != SQLITE_DONE) return Error("cannot take cameras");
  }
  return Execute("COMMIT");
}

Status MatchDatabase::AddFeatures(std::span<const PhotoKeypoints> photos) {
  FREEGS_RETURN_IF_ERROR(Execute("BEGIN IMMEDIATE"));
  const bool typed = HasColumn("descriptors", "type");
  const char* descriptors_sql =
      typed ? "INSERT OR REPLACE INTO descriptors(image_id, rows, cols, data, "
              "type) VALUES(?, ?, ?, ?, ?)"
            : "INSERT OR REPLACE INTO descriptors(image_id, rows, cols, data) "
              "VALUES(?, ?, ?, ?)";
  for (const PhotoKeypoints& photo : photos) {
    const auto rows = static_cast<int64_t>(photo.keypoints->size());
    ByteWriter bytes;
    for (const Keypoint& k : *photo.keypoints) {
      for (const float value : {k.x, k.y, k.scale, k.angle}) bytes.Put(value);
    }
    Statement keypoints(database_.get(),
                        "INSERT OR REPLACE INTO keypoints(image_id, rows, "
                        "cols, data) VALUES(?, ?, 4, ?)");
    if (!keypoints.ok()) return Error("cannot take keypoints");
    keypoints.Bind(1, photo.photo_id);
    keypoints.Bind(2, rows);
    keypoints.BindBlob(3, bytes.content());
    if (keypoints.Step() != SQLITE_DONE) return Error("cannot take keypoints");

    Statement descriptors(database_.get(), descriptors_sql);
    if (!descriptors.ok()) return Error("cannot take descriptors");
    descriptors.Bind(1, photo.photo_id);
    descriptors.Bind(2, rows);
    descriptors.Bind(3, static_cast<int64_t>(kSiftDimensions));
    const std::vector<uint8_t>& values = photo.descriptors->values;
    descriptors.BindBlob(
        4, {reinterpret_cast<const char*>(values.data()), values.size()});
    if (typed) descriptors.Bind(5, kSiftType);
    if (descriptors.Step() != SQLITE_DONE) {
      return Error("cannot take descriptors");
    }
  }
  return Execute("COMMIT");
}

Status MatchDatabase::ClearFeatures() {
  return Execute(
      "BEGIN IMMEDIATE; DELETE FROM keypoints; DELETE FROM descriptors; "
      "COMMIT");
}

Status MatchDatabase::WrongSize(uint32_t id1, uint32_t id2) const {
  return BadInputError(path_.string() + ": the matches of photos " +
                       std::to_string(id1) + " and " + std::to_string(id2) +
                       " are not of their size");
}

bool MatchDatabase::HasColumn(const char* table, const char* column) const {
  return sqlite3_table_column_metadata(database_.get(),
                                       nullptr,
                                       table,
                                       column,
                                       nullptr,
                                       nullptr,
                                       nullptr,
                                       nullptr,
                                       nullptr) == SQLITE_OK;
}

StatusOr<std::vector<MatchDatabase::VerifiedPair>>
MatchDatabase::VerifiedPairs() const {
  const char* table = "two_view_geometries";
  const bool detailed = HasColumn(table, "config") && HasColumn(table, "H");
  std::string sql = "SELECT pair_id, rows, ";
  sql += detailed ? "config, H, " : "0, NULL, ";
  sql += HasColumn(table, "F") ? "F" : "NULL";
  sql += " FROM two_view_geometries WHERE rows > 0 ORDER BY pair_id";
  Statement statement(database_.get(), sql.c_str());
  if (!statement.ok()) return Error("cannot list its pairs");
  std::vector<VerifiedPair> pairs;
  int code;
  while ((code = statement.Step()) == SQLITE_ROW) {
    VerifiedPair pair;
    FREEGS_ASSIGN_OR_RETURN(std::tie(pair.id1, pair.id2),
                            IdsOf(statement.Integer(0)));
    pair.num_matches = statement.Integer(1);
    if (pair.num_matches <= 0) return WrongSize(pair.id1, pair.id2);
    const int64_t config = statement.Integer(2);
    pair.is_homography =
        config >= kFirstHomography && config <= kLastHomography;
    pair.homography = ParseMatrix(statement.Text(3));
    pair.fundamental = ParseMatrix(statement.Text(4));
    pairs.push_back(pair);
  }
  if (code != SQLITE_DONE) return Error("cannot list its pairs");
  return pairs;
}

StatusOr<std::set<std::pair<uint32_t, uint32_t>>> MatchDatabase::ComparedPairs()
    const {
  // COLMAP leaves a row without matches for a pair of which none are verified.
  Statement statement(database_.get(),
                      "SELECT pair_id FROM two_view_geometries");
  if (!statement.ok()) return Error("cannot list its pairs");
  std::set<std::pair<uint32_t, uint32_t>> pairs;
  int code;
  while ((code = statement.Step()) == SQLITE_ROW) {
    FREEGS_ASSIGN_OR_RETURN(const auto ids, IdsOf(statement.Integer(0)));
    pairs.insert(ids);
  }
  if (code != SQLITE_DONE) return Error("cannot list its pairs");
  return pairs;
}

Status MatchDatabase::ForEachVerifiedPair(
    const std::function<
        void(uint32_t, uint32_t, std::span<const FeatureMatch>)>& visit) const {
  Statement statement(database_.get(),
                      "SELECT pair_id, rows, data FROM two_view_geometries "
                      "WHERE rows > 0 ORDER BY pair_id");
  if (!statement.ok()) return Error("cannot list its matches");
  std::vector<FeatureMatch> matches;
  int code;
  while ((code = statement.Step()) == SQLITE_ROW) {
    FREEGS_ASSIGN_OR_RETURN(const auto ids, IdsOf(statement.Integer(0)));
    const std::string data = statement.Text(2);
    // A text counts as larger than 0 in the query above, and as 0 here.
    if (data.empty() || data.size() % 8 != 0 ||
        statement.Integer(1) != static_cast<int64_t>(data.size() / 8)) {
      return WrongSize(ids.first, ids.second);
    }
    matches.resize(data.size() / 8);
    ByteReader reader(data);
    for (FeatureMatch& match : matches) {
      reader.Get(&match.feature1);
      reader.Get(&match.feature2);
    }
    visit(ids.first, ids.second, matches);
  }
  return code == SQLITE_DONE ? Status() : Error("cannot list its matches");
}

Status MatchDatabase::RemoveVerifiedPairs(
    const std::vector<std::pair<uint32_t, uint32_t>>& pairs) {
  FREEGS_RETURN_IF_ERROR(Execute("BEGIN IMMEDIATE"));
  for (const auto& [id1, id2] : pairs) {
    Statement statement(database_.get(),
                        "DELETE FROM two_view_geometries WHERE pair_id = ?");
    if (!statement.ok()) return Error("cannot delete matches");
    statement.Bind(1, std::min(id1, id2) * kMaxImageId + std::max(id1, id2));
    if (statement.Step() != SQLITE_DONE) return Error("cannot delete matches");
  }
  return Execute("COMMIT");
}

Status MatchDatabase::CopyMatchesFrom(const std::filesystem::path& other) {
  Statement attach(database_.get(), "ATTACH DATABASE ? AS other");
  if (!attach.ok()) return Error("cannot attach another database");
  attach.Bind(1, other.string());
  if (attach.Step() != SQLITE_DONE)
    return Error("cannot attach " + other.string());
  Status status = Execute(
      "BEGIN IMMEDIATE;"
      "INSERT OR REPLACE INTO main.matches SELECT * FROM other.matches;"
      "INSERT OR REPLACE INTO main.two_view_geometries "
      "SELECT * FROM other.two_view_geometries;"
      "COMMIT");
  if (!status.ok() && sqlite3_get_autocommit(database_.get()) == 0) {
    (void)Execute("ROLLBACK");
  }
  const Status detached = Execute("DETACH DATABASE other");
  return status.ok() ? detached : status;
}

Status MatchDatabase::CopyTo(const std::filesystem::path& path) const {
  Statement statement(database_.get(), "VACUUM INTO ?");
  if (!statement.ok()) return Error("cannot be copied");
  statement.Bind(1, path.string());
  if (statement.Step() != SQLITE_DONE) {
    return Error("cannot be copied to " + path.string());
  }
  return {};
}

Status MatchDatabase::RenamePhotos(
    const std::function<std::string(uint32_t id)>& name) {
  FREEGS_ASSIGN_OR_RETURN(const std::vector<Photo> photos, Photos());
  FREEGS_RETURN_IF_ERROR(Execute("BEGIN IMMEDIATE"));
  for (const Photo& photo : photos) {
    Statement statement(database_.get(),
                        "UPDATE images SET name = ? WHERE image_id = ?");
    if (!statement.ok()) return Error("cannot rename its photos");
    statement.Bind(1, name(photo.id));
    statement.Bind(2, photo.id);
    if (statement.Step() != SQLITE_DONE) {
      return Error("cannot rename its photos");
    }
  }
  return Execute("COMMIT");
}

Status MatchDatabase::ClearMatchesAndDescriptors() {
  return Execute(
      "BEGIN IMMEDIATE; DELETE FROM matches; "
      "DELETE FROM two_view_geometries; DELETE FROM descriptors; COMMIT");
}

Status CopyDatabase(const std::filesystem::path& from,
                    const std::filesystem::path& to) {
  RemoveDatabase(to);
  FREEGS_ASSIGN_OR_RETURN(const MatchDatabase database,
                          MatchDatabase::Open(from));
  return database.CopyTo(to);
}

Status RemoveVerifiedPairs(
    const std::filesystem::path& path,
    const std::vector<std::pair<uint32_t, uint32_t>>& pairs) {
  FREEGS_ASSIGN_OR_RETURN(MatchDatabase database, MatchDatabase::Open(path));
  return database.RemoveVerifiedPairs(pairs);
}

void RemoveDatabase(const std::filesystem::path& path) {
  std::error_code ignored;
  for (const char* suffix : {"", "-wal", "-shm", "-journal"}) {
    std::filesystem::remove(path.string() + suffix, ignored);
  }
}

}  // namespace freegs::sfm
