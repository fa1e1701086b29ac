//! Runs a test again inside a network namespace of its own: nothing it sends can leave, and no
//! other test hears it.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "code of tests")]

pub(crate) mod datagrams;

use std::process::{Child, Command, Stdio};

/// The loopback interface with multicast on it.
pub(crate) use hil_bench::host::NETWORK_UP as MULTICAST;

/// The group of the tests.
pub(crate) const URL: &str = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304";

/// Runs `body` in the test called `test`, alone in a namespace set up by the commands in `setup`,
/// with `url` where liblcm looks for it.
pub(crate) fn isolated(test: &str, setup: &str, url: &str, body: impl FnOnce()) {
    if std::env::var_os("LMPC_ISOLATED").is_some() {
        return body();
    }
    let output = Command::new("unshare")
        // A test that hangs is a test that failed.
        .args(["-rn", "timeout", "300", "sh", "-c", &format!("{setup} && exec \"$@\""), "sh"])
        .arg(std::env::current_exe().unwrap())
        .args(["--exact", test, "--nocapture"])
        .env("LMPC_ISOLATED", "1")
        .env("LCM_DEFAULT_URL", url)
        .output()
        .expect("`unshare` of util-linux, see tools/setup.sh");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let (out, err) = (text(&output.stdout), text(&output.stderr));
    assert!(output.status.success(), "in the namespace:\n{out}\n{err}");
    assert!(out.contains("1 passed"), "`{test}` is no test:\n{out}\n{err}");
    // Figures, seen with `--nocapture`.
    #[allow(clippy::print_stdout, reason = "code of tests")]
    {
        print!("{out}");
    }
}

/// A process of `lmpc` that ends with the test.
#[allow(dead_code, reason = "not every test starts one")]
pub(crate) struct Program(pub(crate) Child);

#[allow(dead_code, reason = "not every test starts one")]
impl Program {
    pub(crate) fn start(arguments: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lmpc"));
        Self(command.args(arguments).stdout(Stdio::null()).spawn().unwrap())
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.0.kill(); // it may have ended
        let _ = self.0.wait();
    }
}
