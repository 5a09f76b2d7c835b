//! The building of the fine models of one contact: one after the other, or side by side.

use super::fine_side::{FineSide, FineZone};
use super::{AdaptiveContact, CancelCheck};
use crate::body::point_compliance::ObservedPlace;
use crate::error::AdaptiveError;
use crate::record::ZoneSite;
use crate::record::work;
use crate::spec::LowModes;
use crate::system::body::FlexibleModel;

/// The data from which the fine model of one body is built.
#[derive(Clone, Copy)]
pub(super) struct SideRequest<'b, 's> {
    /// The body.
    pub body: &'b FlexibleModel,
    /// Where its contact zone is.
    pub site: &'s ZoneSite,
    /// Observed places of the body, to which the zone adds local deformation.
    pub places: &'s [ObservedPlace],
    /// The low-frequency modes of the fine model: those of the coarse model, or its own.
    pub modes: LowModes,
}

impl AdaptiveContact {
    /// The fine models of both bodies, side by side: each has stages that only one thread can work
    /// on. `check_cancel` waits until both are done.
    ///
    /// # Errors
    /// [`AdaptiveError`] with the name of body or contact, or the error of `check_cancel`.
    pub(super) fn both_sides(
        &self,
        own: SideRequest<'_, '_>,
        target: SideRequest<'_, '_>,
        check_cancel: &mut CancelCheck<'_>,
    ) -> Result<(FineSide, FineSide), AdaptiveError> {
        check_cancel()?;
        if own.body.is_like(target.body) {
            let zones = rayon::join(
                || self.fine_zone(own.body, own.site),
                || self.fine_zone(target.body, target.site),
            );
            // The second takes the matrices of the first.
            let own = self.side(own.body, zones.0?, own.places, own.modes, check_cancel)?;
            return Ok((own, self.side(target.body, zones.1?, target.places, target.modes, check_cancel)?));
        }
        let (own, target) =
            rayon::join(|| self.side_on(own, &mut || Ok(())), || self.side_on(target, &mut || Ok(())));
        check_cancel()?;
        Ok((own?, target?))
    }

    /// The fine model of one body.
    ///
    /// # Errors
    /// [`AdaptiveError`] with the name of body or contact, or the error of `check_cancel`.
    pub(super) fn side_on(
        &self,
        request: SideRequest<'_, '_>,
        check_cancel: &mut CancelCheck<'_>,
    ) -> Result<FineSide, AdaptiveError> {
        let zone = self.fine_zone(request.body, request.site)?;
        let _work = work::begin(format!(
            "\"{}\" with {} unknowns",
            request.body.name(),
            zone.fine.field().n_unknowns()
        ));
        self.side(request.body, zone, request.places, request.modes, check_cancel)
    }

    /// The fine model of `body` at `site` without its matrices, and its contact zone.
    ///
    /// # Errors
    /// [`AdaptiveError`] with the name of body or contact.
    pub(super) fn fine_zone(&self, body: &FlexibleModel, site: &ZoneSite) -> Result<FineZone, AdaptiveError> {
        let fine = self.fine_body(body, site)?;
        let zone = fine.zone(self.law.points, &self.name)?;
        let zone = zone.over_both(body.body.model().thickness(), self.thickness);
        let Some(face) = site.flat_face() else { return Ok(FineZone { fine, zone }) };
        let (grid, rows) = (fine.grid(), fine.contact_elements(&zone));
        let zone = zone.under_edges(face.outward, rows.into_iter().map(|rows| grid.is_at_open_end(rows)));
        Ok(FineZone { fine, zone })
    }
}
