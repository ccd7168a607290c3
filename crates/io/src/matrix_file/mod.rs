//! Writes matrices of distances that are larger than memory: `.npy` files that grow row by row.
//!
//! An unfinished matrix lies in the folder of the final file, under the latter's name with the suffix `.part`. Its
//! checkpoint, `.part.json`, records its inputs and the number of rows that are safely on disk. The last step
//! renames the file.

mod checkpoint;
mod layout;
mod read;
mod symmetric;

use std::cell::Cell;
use std::fs::{self, File, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::{IoError, OutputFile, with_suffix};
use checkpoint::Checkpoint;
pub use checkpoint::{Provenance, surface_checksum};
pub use layout::{Element, MatrixLayout};
pub use read::{SquareMatrix, is_distance_matrix, read_matrix};
use symmetric::write_means;

/// Time between checkpoints. After an interruption, rows since the last checkpoint are computed again.
const BETWEEN_CHECKPOINTS: Duration = Duration::from_secs(5);

/// A matrix that is being written.
///
/// ```
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("distances.npy");
/// use geosweep::io::{Element, MatrixFile, MatrixLayout, OutputFile, Provenance, read_matrix};
/// let layout = MatrixLayout {
///     rows: 3,
///     cols: 3,
///     element: Element::Float32,
///     upper: false,
///     symmetric: false,
/// };
/// let made_from = || Provenance::new().with("surface", "a triangle");
/// let mut file = MatrixFile::begin(OutputFile::new(&path)?, layout, made_from())?;
/// file.append(&[0.0, 3.0, 4.0])?;
/// file.pause()?; // or the machine is switched off
/// assert!(!path.exists());
///
/// let mut file = MatrixFile::resume(OutputFile::new(&path)?, layout, made_from())?;
/// assert_eq!(file.rows(), 1);
/// file.append(&[3.0, 0.0, 5.0, 4.0, 5.0, 0.0])?;
/// file.finish()?;
/// assert_eq!(read_matrix(&path)?.distances[5], 5.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct MatrixFile {
    output: OutputFile,
    layout: MatrixLayout,
    /// Layout of the unfinished file.
    part_layout: MatrixLayout,
    part: PathBuf,
    /// The unfinished file. It is locked, so that no other process writes to it.
    file: File,
    checkpoint: Checkpoint,
    rows: usize,
    saved: Instant,
    buffer: Vec<u8>,
}

impl MatrixFile {
    /// Begins a matrix.
    ///
    /// # Errors
    /// If there is already an unfinished matrix, which is not discarded implicitly; if the disk has too
    /// little space; or if no file can be created.
    pub fn begin(
        output: OutputFile,
        layout: MatrixLayout,
        made_from: Provenance,
    ) -> Result<Self, IoError> {
        let part = part_path(&output);
        layout.check_space(&part, layout.bytes())?;
        let file = File::options().read(true).write(true).create_new(true).open(&part);
        let file = file.map_err(|source| match source.kind() {
            io::ErrorKind::AlreadyExists => IoError::write(
                output.path(),
                format!(
                    "{} holds an unfinished matrix; --resume continues it, or remove it",
                    part.display()
                ),
            ),
            _ => IoError::write(&part, source),
        })?;
        lock(&file, &part)?;
        let checkpoint = Checkpoint::new(made_from, layout.of_rows());
        let mut matrix = Self::new(output, layout, file, checkpoint);
        let header = matrix.part_layout.header();
        matrix.file.write_all(&header).map_err(|source| IoError::write(&matrix.part, source))?;
        matrix.save()?;
        Ok(matrix)
    }

    /// Resumes a matrix where it was interrupted, or begins it if there is none.
    ///
    /// # Errors
    /// If the unfinished matrix was made from other inputs, another process is writing it, or it has lost
    /// data; or if the disk has too little space.
    pub fn resume(
        output: OutputFile,
        layout: MatrixLayout,
        made_from: Provenance,
    ) -> Result<Self, IoError> {
        let part = part_path(&output);
        if !part.exists() {
            return Self::begin(output, layout, made_from);
        }
        let error = |source: io::Error| IoError::write(&part, source);
        let mut file = File::options().read(true).write(true).open(&part).map_err(error)?;
        lock(&file, &part)?;
        let checkpoint = Checkpoint::read(&part)?;
        checkpoint.check(&part, &made_from, layout.of_rows())?;
        check_header(&mut file, &part, &layout.of_rows())?;
        let kept = layout.of_rows().bytes_of_rows(checkpoint.rows);
        let found = file.metadata().map_err(error)?.len();
        if found < kept {
            let reason = format!(
                "holds {found} bytes, and its checkpoint records {kept}; remove it to begin anew"
            );
            return Err(IoError::content(&part, reason));
        }
        layout.check_space(&part, layout.bytes() - kept)?;
        file.set_len(kept).map_err(error)?;
        file.seek(SeekFrom::End(0)).map_err(error)?;
        Ok(Self::new(output, layout, file, checkpoint))
    }

    fn new(output: OutputFile, layout: MatrixLayout, file: File, checkpoint: Checkpoint) -> Self {
        Self {
            part: part_path(&output),
            rows: checkpoint.rows,
            output,
            layout,
            part_layout: layout.of_rows(),
            file,
            checkpoint,
            saved: Instant::now(),
            buffer: Vec::new(),
        }
    }

    /// Returns the number of rows written so far.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Appends whole rows, and saves a checkpoint from time to time.
    ///
    /// # Errors
    /// If the disk is full or fails; the matrix can then be resumed. If a distance is too large for the
    /// element type, no row is written, and nothing is left behind.
    ///
    /// # Panics
    /// If `distances` are not whole rows, or more rows than are missing.
    pub fn append(&mut self, distances: &[f32]) -> Result<(), IoError> {
        let count = distances.len() / self.layout.cols;
        assert_eq!(distances.len(), count * self.layout.cols, "`distances` must be whole rows");
        assert!(self.rows + count <= self.layout.rows, "no more rows than the matrix has");
        let bytes = match self.part_layout.encode(self.rows, distances, &mut self.buffer) {
            Ok(bytes) => bytes,
            Err(reason) => {
                self.discard();
                return Err(IoError::write(self.output.path(), reason));
            }
        };
        self.file.write_all(bytes).map_err(|source| IoError::write(&self.part, source))?;
        self.rows += count;
        if self.saved.elapsed() > BETWEEN_CHECKPOINTS {
            self.save()?;
        }
        Ok(())
    }

    /// Saves the matrix so that it can be resumed. If it has no rows yet, its files are removed.
    ///
    /// # Errors
    /// If the disk is full or fails.
    pub fn pause(mut self) -> Result<(), IoError> {
        if self.rows > 0 {
            return self.save();
        }
        self.discard();
        Ok(())
    }

    /// Finishes the matrix: makes it symmetric if required, and gives it its name.
    ///
    /// # Errors
    /// If the disk is full or fails, or the folder has changed in the meantime; if a mean is too large for
    /// the element type.
    ///
    /// # Panics
    /// If rows are missing.
    pub fn finish(self) -> Result<(), IoError> {
        self.finish_while(|| true).map(drop)
    }

    /// Finishes the matrix as [`Self::finish`] does, but can be interrupted, since making a large matrix symmetric
    /// takes long. It stops once `go_on` returns false. The matrix is then returned with all its rows, so that it can
    /// be paused or discarded.
    ///
    /// # Errors
    /// The errors of [`Self::finish`].
    ///
    /// # Panics
    /// If rows are missing.
    pub fn finish_while(mut self, go_on: impl Fn() -> bool) -> Result<Option<Self>, IoError> {
        assert_eq!(self.rows, self.layout.rows, "all rows are there");
        self.save()?;
        if self.layout.symmetric {
            let (output, layout) = (self.output.clone(), self.layout);
            let interrupted = Cell::new(false);
            let go_on = || {
                interrupted.set(!go_on());
                !interrupted.get()
            };
            let staged = output.stage(|writer| write_means(&mut self.file, layout, writer, go_on));
            if interrupted.get() {
                return Ok(Some(self));
            }
            staged?.commit()?;
            self.discard();
            return Ok(None);
        }
        let error = |source: io::Error| IoError::write(self.output.path(), source);
        fs::rename(&self.part, self.output.target()).map_err(error)?;
        Checkpoint::remove(&self.part);
        Ok(None)
    }

    fn save(&mut self) -> Result<(), IoError> {
        self.file.sync_data().map_err(|source| IoError::write(&self.part, source))?;
        self.checkpoint.rows = self.rows;
        self.saved = Instant::now();
        self.checkpoint.write(&self.part)
    }

    /// Removes the unfinished matrix and its checkpoint. Errors are ignored; the user can then remove the
    /// files.
    pub fn discard(&self) {
        let _ = fs::remove_file(&self.part);
        Checkpoint::remove(&self.part);
    }
}

/// Returns an error for an unfinished matrix whose header differs from the expected one: another program has written to
/// it.
fn check_header(file: &mut File, part: &Path, layout: &MatrixLayout) -> Result<(), IoError> {
    let wanted = layout.header();
    let mut found = vec![0; wanted.len()];
    if file.read_exact(&mut found).is_ok() && found == wanted {
        return Ok(());
    }
    let reason =
        "does not begin as the matrix that its checkpoint describes; remove it to begin anew";
    Err(IoError::content(part, reason))
}

/// Returns the path of the unfinished matrix.
fn part_path(output: &OutputFile) -> PathBuf {
    with_suffix(output.target(), ".part")
}

fn lock(file: &File, part: &Path) -> Result<(), IoError> {
    match file.try_lock() {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => {
            Err(IoError::write(part, "another process is writing this file"))
        }
        // Some network file systems do not support locks.
        Err(TryLockError::Error(source)) if source.kind() == io::ErrorKind::Unsupported => Ok(()),
        Err(TryLockError::Error(source)) => Err(IoError::write(part, source)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAYOUT: MatrixLayout = MatrixLayout {
        rows: 3,
        cols: 3,
        element: Element::Float32,
        upper: false,
        symmetric: false,
    };

    /// Resumes an unfinished matrix of one row after `change` has modified its files.
    fn resumed_after(change: impl FnOnce(&Path, &Path)) -> Result<MatrixFile, IoError> {
        let folder = tempfile::tempdir().unwrap();
        let output = OutputFile::new(&folder.path().join("d.npy")).unwrap();
        let mut matrix = MatrixFile::begin(output.clone(), LAYOUT, Provenance::new()).unwrap();
        matrix.append(&[0.0, 1.0, 2.0]).unwrap();
        let part = part_path(&output);
        matrix.pause().unwrap();
        change(&part, &with_suffix(&part, ".json"));
        MatrixFile::resume(output, LAYOUT, Provenance::new())
    }

    fn refused(change: impl FnOnce(&Path, &Path)) -> String {
        resumed_after(change).unwrap_err().to_string()
    }

    #[test]
    fn an_unfinished_matrix_that_something_has_changed_is_refused() {
        let overwrite = |bytes: &'static [u8]| {
            move |part: &Path, _: &Path| {
                let file = File::options().write(true).open(part);
                file.and_then(|mut file| file.write_all(bytes)).unwrap();
            }
        };
        for bytes in [[0; 16].as_slice(), b"\x93NUMPY\x01\x00\xff\xff"] {
            let message = refused(overwrite(bytes));
            assert!(message.contains("remove it to begin anew"), "{message}");
        }
    }

    #[test]
    fn a_matrix_is_given_back_where_it_is_not_to_be_finished() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("d.npy");
        let layout = MatrixLayout { symmetric: true, ..LAYOUT };
        let output = OutputFile::new(&path).unwrap();
        let mut matrix = MatrixFile::begin(output, layout, Provenance::new()).unwrap();
        matrix.append(&[0.0, 1.0, 2.0, 3.0, 0.0, 4.0, 6.0, 8.0, 0.0]).unwrap();
        let matrix = matrix.finish_while(|| false).unwrap().unwrap();
        let left = |folder: &Path| fs::read_dir(folder).unwrap().count();
        assert_eq!(left(folder.path()), 2, "the matrix and its checkpoint");
        matrix.finish().unwrap();
        assert_eq!(left(folder.path()), 1);
        let means = [0.0, 2.0, 4.0, 2.0, 0.0, 6.0, 4.0, 6.0, 0.0];
        assert_eq!(read_matrix(&path).unwrap().distances, means);
    }

    #[test]
    fn a_checkpoint_that_lies_is_refused() {
        let message = refused(|_, checkpoint| {
            let text = fs::read_to_string(checkpoint).unwrap();
            fs::write(checkpoint, text.replace("\"rows\": 1", "\"rows\": 4000000000000")).unwrap();
        });
        assert!(message.contains("4000000000000 rows"), "{message}");
        let message = refused(|_, checkpoint| fs::remove_file(checkpoint).unwrap());
        assert!(message.contains("without its checkpoint"), "{message}");
    }
}
