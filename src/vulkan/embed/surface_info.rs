//! Defines the parameters of a surface, and checks them.

use super::inputs::{Lookup, Points, SourceBuffer};
use super::outputs::HostImage;
use super::solver::Solver;
use crate::surface::{Chart, EdgeRule, Glued, Gluing, GluingError, SurfaceError, UNGLUED};
use crate::vulkan::grid_images::Purpose;
use crate::vulkan::point_kind::PointKind;
use crate::vulkan::setters::setters;
use crate::vulkan::{TexelChart, VulkanError};

/// Parameters of a surface. The host's images and buffers still belong to the host. They must be alive
/// whenever a recording that uses them runs. Their contents may change from frame to frame.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct SurfaceInfo<'a> {
    /// Size of the grid.
    pub chart: Chart,
    /// Rule by which edges are measured.
    pub edge_rule: EdgeRule,
    /// Number of frames in flight, at least 1. The surface has one image of distances and one record of the outcome
    /// for each; frames write them in turn.
    pub slots: usize,
    /// Queue families that use the images of distances and the packed times: the family of the queue to which
    /// recordings are submitted and the families of the readers, which may be the same. If this lists
    /// different families, their queues share the images without ownership transfers. If it is empty, other
    /// families need ownership transfers.
    pub queue_families: &'a [u32],
    /// Sides of the grid that coincide, so that distances pass from one to the other; see
    /// [`crate::Surface::with_gluing`]. Both sides hold the points of the seam. Copies of a point take the values
    /// of the first copy, and are holes if any copy is a hole. [`super::Outcome::seam_gap`] says how far copies lie apart.
    /// Plans for the surface are made with [`super::Plan::over_seams`]. The gluing cannot be [`Gluing::Charts`],
    /// which depends on positions.
    pub gluing: Option<&'a Gluing>,
    /// Whether cells may be so skewed that fronts arrive from points more than six rows or columns away. Updates then look
    /// for points up to 16 away, which resolves axes of the metric with a ratio of 30 instead of 10. Creating the surface
    /// then also creates pipelines of its own for all schedules and wavefronts that the solver has at that time. An update
    /// takes longer only where cells are that skewed. [`super::Outcome::unresolved`] says whether it is enough. The sides of such
    /// a grid cannot be glued.
    pub has_skewed_cells: bool,
    /// Images of the host for the distances, one per slot. If this is empty, the surface allocates them. See
    /// [`HostImage`].
    pub results: &'a [HostImage],
    /// Points that recordings select by number, for instance one entry for each frame in flight. If any of
    /// them has a slowness, the surface takes 4 more bytes per point. Creating the surface then also creates
    /// pipelines with slowness for all schedules and wavefronts that the solver has at that time. Planar
    /// fronts take the place of circular ones.
    pub points: &'a [Points],
    /// Source buffers that recordings select by number.
    pub sources: &'a [SourceBuffer],
    /// Buffers for lookups, which recordings select by number.
    pub lookups: &'a [Lookup],
    /// Name of the surface in labels and names of objects, for debugging tools and the validation layers
    /// ([`super::Tools::labels`]). With `None` it is `surface` and a number.
    pub name: Option<&'a str>,
}

/// Size of the grid and of its images, the purpose of these, and the gluing.
type Wanted<'f> = ((Chart, TexelChart), Purpose<'f>, Option<Glued>);

impl<'a> SurfaceInfo<'a> {
    /// Returns the parameters of a grid with one slot, and with no memory of the host.
    pub fn new(chart: Chart) -> Self {
        Self {
            chart,
            edge_rule: EdgeRule::default(),
            slots: 1,
            queue_families: &[],
            gluing: None,
            has_skewed_cells: false,
            results: &[],
            points: &[],
            sources: &[],
            lookups: &[],
            name: None,
        }
    }

    /// Sets [`SurfaceInfo::name`].
    pub fn with_name(self, name: impl Into<Option<&'a str>>) -> Self {
        Self { name: name.into(), ..self }
    }

    /// Sets [`SurfaceInfo::gluing`].
    pub fn with_gluing(self, gluing: impl Into<Option<&'a Gluing>>) -> Self {
        Self { gluing: gluing.into(), ..self }
    }

    setters! {
        with_edge_rule(edge_rule: EdgeRule);
        with_slots(slots: usize);
        with_skewed_cells(has_skewed_cells: bool);
        with_queue_families(queue_families: &'a [u32]);
        with_results(results: &'a [HostImage]);
        with_points(points: &'a [Points]);
        with_sources(sources: &'a [SourceBuffer]);
        with_lookups(lookups: &'a [Lookup]);
    }

    /// Returns each queue family once.
    pub(super) fn families(&self) -> Vec<u32> {
        let mut families = self.queue_families.to_vec();
        families.sort_unstable();
        families.dedup();
        families
    }

    /// Returns the gluing of the grid, after checking that all points allow it.
    pub(super) fn glued(&self) -> Result<Option<Glued>, VulkanError> {
        let Some(gluing) = self.gluing else { return Ok(None) };
        if self.has_skewed_cells {
            let what = "the search for points far away in skewed cells";
            return Err(
                SurfaceError::from(GluingError::Unsupported { what, instead: UNGLUED }).into()
            );
        }
        self.points.iter().try_for_each(|points| check_kind(gluing, points.kind))?;
        Ok(Some(Glued::of_grid(self.chart, gluing).map_err(SurfaceError::from)?))
    }

    /// Checks the parameters, and returns the values that follow from them.
    pub(super) fn wanted<'f>(
        &self,
        solver: &Solver,
        families: &'f [u32],
    ) -> Result<Wanted<'f>, VulkanError> {
        self.check()?;
        let size = (self.chart, solver.limits.texels(self.chart)?);
        let glued = self.glued()?;
        let lattice = glued.as_ref().map(Glued::lattice).unwrap_or_default();
        let slowed = self.points.iter().any(|points| points.slowness.is_some());
        let slots = self.slots.max(1);
        let results = if self.results.is_empty() { slots } else { 0 };
        Ok((
            size,
            Purpose { slowed, slots: Some(slots), results, families, lattice, owner: "" },
            glued,
        ))
    }

    fn check(&self) -> Result<(), VulkanError> {
        let Chart { rows, cols } = self.chart;
        if rows == 0 || cols == 0 {
            return Err(SurfaceError::Empty { rows, cols }.into());
        }
        let (given, slots) = (self.results.len(), self.slots.max(1));
        if given != 0 && given != slots {
            let reason = format!("{given} results are given for {slots} slots");
            return Err(VulkanError::HostBuffer { what: "distances", reason });
        }
        self.results.iter().try_for_each(|image| image.check("distances"))
    }
}

/// Returns an error if points of a kind do not allow a gluing.
pub(super) fn check_kind(gluing: &Gluing, kind: PointKind) -> Result<(), VulkanError> {
    let is_in_space = matches!(kind, PointKind::Positions);
    let checked = gluing.check_geometry(kind.has_positions(), is_in_space);
    Ok(checked.map_err(SurfaceError::from)?)
}
