//! A revision checked out beside the working tree, for as long as it is needed.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tetrascope::core::Error;

use crate::cargo::not_started;

/// A checkout that is gone when this is dropped. Where the program was killed, the next one
/// puts away what it left.
pub struct Worktree {
    repository: PathBuf,
    checkout: PathBuf,
    results: PathBuf,
    revision: String,
    /// Locked for as long as this lives: the folder is one program's.
    lock: File,
}

/// The full name of a commit.
///
/// # Errors
/// There is no such revision, or no git.
pub fn resolve(repository: &Path, revision: &str) -> Result<String, Error> {
    let commit = format!("{revision}^{{commit}}");
    let output = git(
        repository,
        &[
            "rev-parse",
            "--verify",
            "--quiet",
            "--end-of-options",
            &commit,
        ],
    )?;
    let name = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    match output.status.success() && !name.is_empty() {
        true => Ok(name),
        false => Err(Error::Usage {
            what: format!("no revision '{revision}' in this repository"),
            help: Some("name a commit, branch or tag, such as main or HEAD~1".into()),
        }),
    }
}

impl Worktree {
    /// Checks a revision out into a folder, in which it may stay alone.
    ///
    /// # Errors
    /// Another program has the folder; git fails; the folder cannot be written.
    pub fn new(repository: &Path, folder: &Path, revision: &str) -> Result<Worktree, Error> {
        let failed = |source| Error::Io {
            action: "cannot write",
            path: folder.into(),
            source,
        };
        std::fs::create_dir_all(folder).map_err(failed)?;
        let lock = File::create(folder.join("lock")).map_err(failed)?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(std::fs::TryLockError::WouldBlock) => {
                return Err(Error::Usage {
                    what: format!("another comparison runs in {}", folder.display()),
                    help: Some("wait until it ends".into()),
                });
            }
            Err(std::fs::TryLockError::Error(source)) => return Err(failed(source)),
        }
        let worktree = Worktree {
            repository: repository.into(),
            checkout: folder.join("base"),
            results: folder.join("results"),
            revision: revision.into(),
            lock,
        };
        // What was killed has left this.
        worktree.remove();
        let checkout = worktree.checkout.to_string_lossy().into_owned();
        let add = [
            "worktree", "add", "--detach", "--force", "--quiet", &checkout, revision,
        ];
        let output = git(repository, &add)?;
        if !output.status.success() {
            let reason = String::from_utf8_lossy(&output.stderr);
            return Err(Error::Invalid {
                what: format!("git cannot check {revision} out: {}", reason.trim()),
                help: None,
            });
        }
        Ok(worktree)
    }

    /// Where the revision is.
    pub fn path(&self) -> &Path {
        &self.checkout
    }

    /// A folder for results, gone with the checkout.
    pub fn results(&self) -> &Path {
        &self.results
    }

    /// The revision in few characters.
    pub fn short(&self) -> &str {
        self.revision.get(..10).unwrap_or(&self.revision)
    }

    fn remove(&self) {
        let checkout = self.checkout.to_string_lossy();
        _ = git(
            &self.repository,
            &["worktree", "remove", "--force", "--force", &checkout],
        );
        // What git does not know of any more.
        for folder in [&self.checkout, &self.results] {
            if let Err(error) = std::fs::remove_dir_all(folder)
                && error.kind() != std::io::ErrorKind::NotFound
            {
                eprintln!("cannot delete {}: {error}", folder.display());
            }
        }
    }
}

impl Drop for Worktree {
    fn drop(&mut self) {
        self.remove();
        // Closing alone would leave it to a program that is being started meanwhile, which has the file until then.
        drop(self.lock.unlock());
    }
}

fn git(repository: &Path, arguments: &[&str]) -> Result<Output, Error> {
    let mut git = Command::new("git");
    git.current_dir(repository).args(arguments);
    git.output().map_err(|source| not_started(&git, source))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A repository with two commits of one file.
    fn repository() -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let run = |arguments: &[&str]| {
            let mut git = Command::new("git");
            git.current_dir(folder.path());
            git.args(["-c", "user.name=a", "-c", "user.email=a@example.org"]);
            let output = git.args(arguments).output().expect("git runs");
            assert!(output.status.success(), "{output:?}");
        };
        run(&["init", "--quiet", "."]);
        for text in ["first", "second"] {
            std::fs::write(folder.path().join("file"), text).expect("written");
            run(&["add", "file"]);
            run(&["commit", "--quiet", "--message", text]);
        }
        folder
    }

    #[test]
    fn a_revision_is_checked_out_and_put_away() {
        let repository = repository();
        let place = repository.path().join("target").join("against");
        let first = resolve(repository.path(), "HEAD~1").expect("there are two");
        for _ in 0..2 {
            let worktree = Worktree::new(repository.path(), &place, &first).expect("checked out");
            let text = std::fs::read_to_string(worktree.path().join("file")).expect("there");
            assert_eq!(text, "first");
            let second = Worktree::new(repository.path(), &place, &first);
            let error = second.map(drop).expect_err("it is locked").to_string();
            assert!(error.contains("another comparison"), "{error}");
            assert!(worktree.path().exists());
        }
        assert!(!place.join("base").exists());
        let listed = git(repository.path(), &["worktree", "list"]).expect("git runs");
        assert_eq!(String::from_utf8_lossy(&listed.stdout).lines().count(), 1);
    }

    #[test]
    fn what_a_killed_program_left_is_put_away() {
        let repository = repository();
        let place = repository.path().join("target").join("against");
        let head = resolve(repository.path(), "HEAD").expect("a commit");
        let killed = Worktree::new(repository.path(), &place, &head).expect("checked out");
        std::fs::write(killed.path().join("file"), "changed").expect("written");
        let results = killed.results().to_owned();
        std::fs::create_dir_all(&results).expect("made");
        killed.lock.unlock().expect("locked before");
        std::mem::forget(killed);
        let next = Worktree::new(repository.path(), &place, &head).expect("checked out again");
        let text = std::fs::read_to_string(next.path().join("file")).expect("there");
        assert_eq!(text, "second");
        assert!(!results.exists());
    }

    #[test]
    fn an_unknown_revision_is_one_line() {
        let repository = repository();
        for name in ["nothing", "", "--all", "HEAD:file", "a\nb"] {
            let error = resolve(repository.path(), name).expect_err(name);
            assert_eq!(error.kind(), tetrascope::core::ErrorKind::Usage);
            assert!(error.to_string().contains("no revision"), "{error}");
            assert_eq!(error.to_string().lines().count(), 1, "{error}");
        }
    }
}
