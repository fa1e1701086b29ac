//! A campaign as an array of jobs.

use std::fmt::Write as _;
use std::path::Path;

/// The script of a Slurm array with one job for each shard.
///
/// `program` is how lmpc is called, `out` the folder of the campaign, `jobs` the processors of a job.
#[must_use]
pub fn script(program: &Path, file: &Path, out: &Path, shards: usize, jobs: u32) -> String {
    let name = file.file_stem().map_or("campaign".into(), |stem| stem.to_string_lossy());
    let plain: String = name
        .chars()
        .map(|c| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' })
        .collect();
    let quoted = |path: &Path| format!("'{}'", path.display().to_string().replace('\'', "'\\''"));
    let (program, file, folder) = (quoted(program), quoted(file), quoted(out));
    let mut text = String::new();
    let _ = write!(
        text,
        "#!/bin/sh\n\
         #SBATCH --job-name={plain}\n\
         #SBATCH --array=1-{shards}\n\
         #SBATCH --cpus-per-task={jobs}\n\
         #SBATCH --requeue\n\
         #SBATCH --output={plain}-%A_%a.log\n\
         # A job that is requeued goes on where it stopped. Code 3: runs failed, which is a result.\n\
         # When all have ended: {program} study merge {folder}/shard-* --out {folder}\n\
         {program} study {file} --shard \"$SLURM_ARRAY_TASK_ID/{shards}\" \\\n    \
         --jobs \"${{SLURM_CPUS_PER_TASK:-{jobs}}}\" --out {folder}\n\
         code=$?\n\
         [ $code -ne 3 ] || code=0\n\
         exit $code\n"
    );
    text
}
