//! Campaigns: what there is to run, one run at a time, and the table on disk.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use studies::campaign::{
    Campaign as Inner, CampaignCase, CampaignColumns, CampaignRow, Rows, drive,
};

use crate::errors::{CampaignError, raise};

/// A campaign from a file, as ``lmpc study`` runs it.
///
/// Each of its runs is a function of its row: whoever drives it gets the same fields, to the last
/// bit. `racing_lmpc.engines.study` drives all of them on a cluster.
///
/// Reads the file of a campaign.
///
/// Raises:
///     CampaignError: the file, or a file it names, is missing or wrong.
#[pyclass(frozen, module = "racing_lmpc")]
pub(crate) struct Campaign {
    inner: Arc<Inner>,
    columns: CampaignColumns,
}

impl Campaign {
    fn case(&self, number: usize) -> PyResult<&CampaignCase> {
        let cases = &self.inner.cases;
        let missing = || anyhow::anyhow!("no run {number}, expected one of {}", cases.len());
        cases
            .iter()
            .find(|case| case.number == number)
            .ok_or_else(|| raise::<CampaignError>(missing()))
    }
}

#[pymethods]
impl Campaign {
    #[new]
    fn new(path: PathBuf) -> PyResult<Self> {
        let inner = Inner::load(&path).map_err(raise::<CampaignError>)?;
        let columns = inner.columns();
        Ok(Self { inner: Arc::new(inner), columns })
    }

    /// Heading.
    #[getter]
    fn title(&self) -> &str {
        &self.inner.title
    }

    /// Keys of the axes.
    #[getter]
    fn axes(&self) -> Vec<String> {
        self.inner.axes.clone()
    }

    /// Names of the columns of ``runs.csv``.
    #[getter]
    fn columns(&self) -> Vec<String> {
        self.columns.names().map(str::to_owned).collect()
    }

    /// Numbers of the runs.
    #[getter]
    fn runs(&self) -> Vec<usize> {
        self.inner.cases.iter().map(|case| case.number).collect()
    }

    /// Fingerprint of everything that is set in a run but the seed, and of the version.
    fn settings(&self, run: usize) -> PyResult<String> {
        Ok(self.case(run)?.settings.clone())
    }

    /// Drives a run and returns its fields in the order of `columns`. Releases the interpreter's
    /// lock. A car that fails is a result.
    fn drive(&self, py: Python<'_>, run: usize) -> PyResult<Vec<String>> {
        let case = self.case(run)?;
        let row = py.detach(|| drive(&self.inner, &self.columns, case));
        Ok(row.fields().map(str::to_owned).collect())
    }

    /// Opens the table in a folder, which keeps the runs that it has; with `fresh` it begins a new
    /// one. One folder takes one program at a time.
    ///
    /// Raises:
    ///     CampaignError: the table has other columns or a line that is no row, another program
    ///         writes to it, or it cannot be written.
    #[pyo3(signature = (folder, fresh = false))]
    fn open(&self, folder: PathBuf, fresh: bool) -> PyResult<CampaignTable> {
        let cases: Vec<&CampaignCase> = self.inner.cases.iter().collect();
        let rows =
            Rows::open(&folder, &self.inner, &cases, fresh).map_err(raise::<CampaignError>)?;
        Ok(CampaignTable { campaign: Arc::clone(&self.inner), rows: Some(rows) })
    }
}

/// The table of a campaign on disk: a line a run, written as soon as it is added.
#[pyclass(module = "racing_lmpc")]
pub(crate) struct CampaignTable {
    campaign: Arc<Inner>,
    rows: Option<Rows>,
}

#[pymethods]
impl CampaignTable {
    /// Numbers of the runs that are not in it.
    #[getter]
    fn missing(&self) -> Vec<usize> {
        let done = self.rows.as_ref().map(Rows::done).unwrap_or_default();
        let all = self.campaign.cases.iter().map(|case| case.number);
        all.filter(|number| !done.contains(number)).collect()
    }

    /// Adds the fields of a run. A run that is in it already, because two workers drove it, is
    /// left out.
    ///
    /// Raises:
    ///     CampaignError: the fields are not those of a run of this campaign, or the table is closed.
    fn add(&mut self, fields: Vec<String>) -> PyResult<()> {
        let campaign = &self.campaign;
        let rows = self.rows.as_mut().ok_or_else(closed)?;
        let row =
            CampaignRow::of(fields, campaign, rows.columns()).map_err(raise::<CampaignError>)?;
        if rows.done().contains(&row.number()) {
            return Ok(());
        }
        rows.add(row).map_err(raise::<CampaignError>)
    }

    /// Puts the runs into the order of their numbers and lets the folder go.
    fn close(&mut self) -> PyResult<()> {
        let Some(mut rows) = self.rows.take() else { return Ok(()) };
        rows.sort().map_err(raise::<CampaignError>)
    }
}

fn closed() -> PyErr {
    raise::<CampaignError>(anyhow::anyhow!("the table is closed"))
}
